/// What a report must know of a run's team, as the log keeps it.
#pragma once

#include <string>

#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Bodies with their names, robots, limits and tags; pairs of observer and target; who is coupled with whom and which of
/// the two feel it, each once; robots that are kept apart; names of the events. Of all of the run, whatever its events change.
std::string team_json(const Scenario& scenario);

}  // namespace sightline
