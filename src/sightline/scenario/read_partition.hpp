/// [partition]: parts of the team that plan by themselves, and how they exchange what they predict.
#pragma once

#include <string>

#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "sightline/solver/distributed/partition.hpp"

namespace sightline {

/// [partition], where there is one; where it says so, the scenario becomes that of its part.
/// @throws ScenarioError
void read_partition(const TomlTable& root, Scenario& scenario);

/// @throws std::invalid_argument where parts of the scenario's team cannot plan by themselves
void check_plans_in_parts(const Scenario& scenario);

/// The parts as a solver wants them, ids of that team.
Partition partition_of(const PartitionPlan& plan, const Team& team);

/// The scenario of the part that is planned here: its robots are the team, all other bodies are seen; robots of other parts among
/// them. What concerns others alone is left out.
/// @throws std::invalid_argument for what a part cannot fly
Scenario part_of(const Scenario& whole);

/// Lines for the summary of a scenario.
std::string in_words(const PartitionPlan& plan);

}  // namespace sightline
