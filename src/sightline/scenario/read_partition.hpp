/// Reads [partition]: parts of the team that plan separately and exchange their predictions.
#pragma once

#include <string>

#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "sightline/solvers.hpp"

namespace sightline {

/// Reads [partition], if there is one. If it selects a part, the scenario becomes that of the part.
/// @throws ScenarioError
void read_partition(const TomlTable& root, ScenarioSpec& scenario);

/// @throws std::invalid_argument if parts of the scenario's team cannot plan separately
void check_plans_in_parts(const ScenarioSpec& scenario, const Registry& registry);

/// The parts as agent ids of that team, for a solver.
Partition partition_of(const PartitionPlan& plan, const Team& team);

/// The scenario of the part that is planned on this computer. Its robots form the team; all other
/// bodies, robots of other parts included, are seen only. Omits what concerns other parts alone.
/// @throws std::invalid_argument for a feature that a part does not support
ScenarioSpec part_of(const ScenarioSpec& whole);

/// Lines for the summary of a scenario.
std::string describe(const PartitionPlan& plan);

}  // namespace sightline
