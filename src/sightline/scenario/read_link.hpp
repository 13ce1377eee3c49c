/// Reads [fleet], [agent.NAME.link], [target.NAME.link] and [obstacle.NAME.link].
#pragma once

#include <optional>
#include <string>

#include "sightline/scenario/link.hpp"
#include "sightline/scenario/read_link_fault.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// [fleet]; none without it.
/// @throws ScenarioError
std::optional<FleetNetwork> read_fleet(const TomlTable& root);

/// Reads [agent.NAME.link] and adds it to the fleet, if there is one. Every robot of a fleet has a
/// link; without a fleet none has.
/// @param goals  of the same table
/// @throws ScenarioError
void read_link(const TomlTable& agent, const std::string& name, BodyId robot, GoalsFrom goals,
               std::optional<FleetPlan>& fleet);

/// Reads the goals of [agent.NAME.link]; the robot's reference becomes one that goals change.
/// @throws ScenarioError
GoalsFrom read_goals(const TomlTable& agent, Agent& robot);

/// Reads [target.NAME.link] or [obstacle.NAME.link], which are optional, and adds it to the fleet.
/// @throws ScenarioError
void read_body_link(const TomlTable& at, BodyId body, std::optional<FleetPlan>& fleet);

/// Lines for the summary of a scenario.
std::string in_words(const FleetPlan& fleet, const Team& team);

}  // namespace sightline
