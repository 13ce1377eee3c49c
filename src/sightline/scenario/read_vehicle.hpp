/// [agent.NAME.vehicle]: what the robot is in a world of vehicles.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "sightline/scenario/toml_table.hpp"
#include "sightline/world/downwash.hpp"
#include "sightline/world/vehicle.hpp"

namespace sightline {

/// The file that `model` names, in a world that reads such files.
ModelFile read_model_file(const TomlTable& at);
/// @throws ScenarioError for one of the keys, of model files, in a world that reads none
void refuse_without_models(const TomlTable& at, std::span<const std::string_view> keys,
                           std::string_view world);

/// What [world] says of the vehicles' downwash, refused in a world without vehicles.
/// @param kind    what the scenario flies in
/// @param beside  other keys of [world]
DownwashOptions read_downwash(const TomlTable& world, std::string_view kind,
                              std::span<const std::string_view> beside);

/// The vehicle that a robot is; an x500 where nothing is said of it. None in a world without vehicles, and of a robot that cannot be
/// one; a table that would not be looked at is refused.
/// @param agent  [agent.NAME]
/// @param world  what the scenario flies in
/// @throws ScenarioError
std::optional<RobotVehicle> read_vehicle(const TomlTable& agent, const Model& model, std::string_view world);

}  // namespace sightline
