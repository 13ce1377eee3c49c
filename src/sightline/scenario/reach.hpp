/// What the inputs of a robot can change, and the limits that no robot they act on can change.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// For each entry of a robot's sight, in the order of `write_sight`: whether the inputs change it,
/// directly or through other states.
std::array<bool, sight_size> reach_of(const Model& model);

/// For each entry of the observer's sight, then of the target's: whether the potential's value
/// depends on it.
std::array<bool, 2 * sight_size> seen_by(const Potential& potential);

/// The couplings of a scenario's team, then those that its events add.
std::vector<Coupling> stated_couplings(const ScenarioSpec& scenario);

/// A sentence for each coupling and constraint, events' ones included, that none of the robots it
/// acts on can change.
std::vector<std::string> limits_beyond_influence(const Scenario& scenario);

/// A sentence for each robot with a noise or fault of the scenario that no state of its model can
/// take.
std::vector<std::string> robots_beyond_noise(const Scenario& scenario);

}  // namespace sightline
