/// What the actions of events change in a team.
#pragma once

#include <string>
#include <string_view>

#include "sightline/events.hpp"

namespace sightline {

/// Begin of the names of couplings that are the set of a certified view. One stays in force as long
/// as another coupling observes its pair.
inline constexpr std::string_view name_of_view_sets = "certify_view[";

/// Whether the first of a pair observes the second by this coupling.
bool is_view_of(const Coupling& coupling, Between pair);

/// Applies an action at time t [s]; weights are blended over `ramp` [s].
/// @return the reason of a rejection, a sentence, with nothing changed; else empty
std::string apply_action(const Action& action, TeamState& now, double t, double ramp);

}  // namespace sightline
