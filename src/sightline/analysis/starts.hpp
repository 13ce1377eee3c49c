/// Where a scenario's bodies stand before the flight, against its floor, ceiling, world and hard distances.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// A sentence for each start that breaks what [safety] asks, and for each body that an event adds where another
/// starts. Bodies that are absent at first count from their event on.
std::vector<std::string> warnings_of_starts(const Scenario& scenario);

}  // namespace sightline
