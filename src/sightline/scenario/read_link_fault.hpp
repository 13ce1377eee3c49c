/// Reads [[fleet.fault]].
#pragma once

#include "sightline/scenario/link.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// Adds the faults of [fleet] to the fleet. Requires its links.
/// @throws ScenarioError
void read_link_faults(const TomlTable& at, const Team& team, FleetPlan& fleet);

}  // namespace sightline
