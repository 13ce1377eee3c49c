#include "sightline/scenario/read_vehicle.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "sightline/scenario/parts.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/world/flight_controller.hpp"

namespace sightline {

std::optional<RobotVehicle> read_vehicle(const TomlTable& agent, const Model& model, std::string_view world) {
  constexpr std::string_view key = "vehicle";
  const auto worlds = agent.parts().worlds.with_vehicles();
  const bool has_vehicles = std::find(worlds.begin(), worlds.end(), world) != worlds.end();
  const std::optional<Commands> commands = commands_of(model);
  if (agent.has(key) && !has_vehicles) {
    agent.refuse(key, fmt::format("no such table in the world \"{}\", only with world.kind = \"{}\"", world,
                                  fmt::join(worlds, "\" or \"")));
  }
  if (agent.has(key) && !commands) {
    agent.refuse(key, fmt::format("no such table, the robot {} is no vehicle: those are {}", model.name(),
                                  robots_with_vehicles()));
  }
  if (!has_vehicles || !commands) return std::nullopt;
  if (commands == Commands::full_state && !agent.has(key)) return std::nullopt;  // a point may stay one

  const TomlTable at = agent.table_or_empty(key);
  const VehicleOfModel of_model = agent.parts().worlds.of_model(world);
  const std::array<std::string_view, 2> of_file = {"model", "body"};
  RobotVehicle read;
  read.vehicle = read_part<Vehicle>(TableSource(at), std::span(of_file).first(of_model ? 2 : 0));
  if (at.has("preset")) read.preset = at.text("preset", "a preset");
  if (at.has("body") && !at.has("model")) at.refuse("model", "the file that body is of");
  if (at.has("model")) {
    read.model = ModelBody{read_model_file(at), at.has("body") ? at.text("body", "the name of a body") : ""};
    // A log is flown again without the world, and without the files that its models name.
    if (!at.from_disk()) return read;
    const Vehicle body = at.checked([&] { return of_model(read.vehicle, *read.model); });
    if (!at.has("mass")) read.vehicle.mass = body.mass;
    if (!at.has("inertia")) read.vehicle.inertia = body.inertia;
  }
  at.checked([&] { read.vehicle.check(); });
  return read;
}

ModelFile read_model_file(const TomlTable& at) {
  const std::string name = at.text("model", "the name of a file");
  if (name.empty()) at.refuse("model", "the name of a file");
  return {.name = name, .text = at.file_text(name), .folder = at.file_folder(name)};
}

}  // namespace sightline
