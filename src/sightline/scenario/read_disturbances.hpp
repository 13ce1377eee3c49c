/// Reads [simulation.disturbance] of a scenario.
#pragma once

#include "sightline/scenario/toml_table.hpp"
#include "sightline/world.hpp"

namespace sightline {

/// Wind is [x, y, z] or, if horizontal, { size, direction }: the direction into which it blows,
/// from the x axis of G to the left.
/// @throws ScenarioError
Disturbances read_disturbances(const TomlTable& at);

}  // namespace sightline
