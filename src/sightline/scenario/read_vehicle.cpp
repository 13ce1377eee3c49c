#include "sightline/scenario/read_vehicle.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sightline/scenario/parts.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/world/flight_controller.hpp"

namespace sightline {

std::optional<RobotVehicle> read_vehicle(const TomlTable& agent, const Model& model, std::string_view world) {
  constexpr std::string_view key = "vehicle";
  const auto worlds = agent.parts().worlds.with_vehicles();
  const bool has_vehicles = std::find(worlds.begin(), worlds.end(), world) != worlds.end();
  const bool can_be_one = commands_of(model).has_value();
  if (agent.has(key) && !has_vehicles) {
    agent.refuse(key, fmt::format("no such table in the world \"{}\", only with world.kind = \"{}\"", world,
                                  fmt::join(worlds, "\" or \"")));
  }
  if (agent.has(key) && !can_be_one) {
    agent.refuse(key, fmt::format("no such table, the robot {} is no vehicle: those are {}", model.name(),
                                  robots_with_vehicles()));
  }
  if (!has_vehicles || !can_be_one) return std::nullopt;

  const TomlTable at = agent.table_or_empty(key);
  RobotVehicle read;
  read.vehicle = read_part<Vehicle>(TableSource(at));
  at.checked([&] { read.vehicle.check(); });
  if (at.has("preset")) read.preset = at.text("preset", "a preset");
  return read;
}

}  // namespace sightline
