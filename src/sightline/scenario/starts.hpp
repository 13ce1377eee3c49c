/// Checks the bodies' starts against the floor, ceiling, world and hard distances of a scenario.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// A sentence for each start that violates [safety], and for each body that joins by an event at
/// the start of another. Bodies that are absent at first count from their event on.
std::vector<std::string> warnings_of_starts(const Scenario& scenario);

}  // namespace sightline
