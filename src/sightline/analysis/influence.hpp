/// What the inputs of a robot can change, and limits that no robot that feels them can change.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Of what is seen of a robot, in the order of `write_sight`: whether its inputs change it, sooner or later.
std::array<bool, sight_size> reach_of(const Model& model);

/// Of what a potential sees of its observer, then of its target: whether its value depends on it.
std::array<bool, 2 * sight_size> seen_by(const Potential& potential);

/// The couplings of a scenario's team, then those that its events add.
std::vector<Coupling> said_couplings(const Scenario& scenario);

/// A sentence for each coupling and constraint, events' ones included, that none of the robots that feel it can change.
std::vector<std::string> limits_beyond_influence(const Scenario& scenario);

/// A sentence for each robot that noise or faults of the scenario do not reach, since its states are none of theirs.
std::vector<std::string> robots_beyond_noise(const Scenario& scenario);

}  // namespace sightline
