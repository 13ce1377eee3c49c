/// Description of a run's team in the log, for reports.
#pragma once

#include <string>

#include "sightline/scenario.hpp"

namespace sightline {

/// JSON with bodies and their names, robots, limits and tags; pairs of observer and target;
/// couplings, each once, with the bodies that they affect; robots kept apart; hard distances;
/// floor, ceiling and polygons of zones; event names. Covers the whole run, independent of its
/// events.
std::string team_json(const Scenario& scenario);

}  // namespace sightline
