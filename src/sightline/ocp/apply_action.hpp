/// What the actions of events change in a team.
#pragma once

#include <string>

#include "sightline/events.hpp"

namespace sightline {

/// Applies an action at time t [s]; weights are blended over `ramp` [s].
/// @return the reason of a rejection, a sentence, with nothing changed; else empty
std::string apply_action(const Action& action, TeamState& now, double t, double ramp);

}  // namespace sightline
