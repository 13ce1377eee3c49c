/// Reads [agent.NAME.vehicle]: the vehicle that represents a robot in a world of vehicles.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "sightline/scenario/toml_table.hpp"
#include "sightline/vehicle.hpp"

namespace sightline {

/// The file that `model` names, in a world that reads model files.
ModelFile read_model_file(const TomlTable& at);
/// @throws ScenarioError for one of the keys of model files, in a world that reads none
void refuse_without_models(const TomlTable& at, std::span<const std::string_view> keys,
                           std::string_view world);

/// Reads the downwash options of [world]; rejects them in a world without vehicles.
/// @param kind    of the world
/// @param beside  other keys of [world]
DownwashOptions read_downwash(const TomlTable& world, std::string_view kind,
                              std::span<const std::string_view> beside);

/// The vehicle of a robot; an x500 by default. None in a world without vehicles, and for a robot
/// that cannot be a vehicle; there the table is rejected.
/// @param agent  [agent.NAME]
/// @param world  kind of the world
/// @throws ScenarioError
std::optional<RobotVehicle> read_vehicle(const TomlTable& agent, const Model& model, std::string_view world);

}  // namespace sightline
