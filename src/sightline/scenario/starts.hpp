/// Starts of the bodies, and their checks against the floor, ceiling, world and hard distances of a
/// scenario.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// Whether a body is in the team only from an event on.
bool is_absent_at_start(const Scenario& scenario, BodyId body);

/// Sight of a body at its start, without inputs. Set-up: allocates.
Sight<double> sight_at_start(const Scenario& scenario, BodyId body);

/// A sentence for each start that violates [safety], and for each body that joins by an event at
/// the start of another. Bodies that are absent at first count from their event on.
std::vector<std::string> warnings_of_starts(const Scenario& scenario);

}  // namespace sightline
