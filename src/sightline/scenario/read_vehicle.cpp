#include "sightline/scenario/read_vehicle.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "sightline/registry.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/world/flight_controller.hpp"

namespace sightline {
namespace {

bool has_vehicles(const TomlTable& at, std::string_view world) {
  const auto worlds = at.registry().worlds.names(&WorldPart::has_vehicles);
  return std::find(worlds.begin(), worlds.end(), world) != worlds.end();
}

/// Rejects a key that only a world of vehicles uses.
/// @param what  "table" or "key", for the sentence
void refuse_without_vehicles(const TomlTable& at, std::string_view key, std::string_view what,
                             std::string_view world) {
  if (!at.has(key) || has_vehicles(at, world)) return;
  at.throw_invalid(key,
                   fmt::format("no such {} in the world \"{}\", only with world.kind = \"{}\"", what, world,
                               fmt::join(at.registry().worlds.names(&WorldPart::has_vehicles), "\" or \"")));
}

}  // namespace

DownwashOptions read_downwash(const TomlTable& world, std::string_view kind,
                              std::span<const std::string_view> beside) {
  for (const std::string_view key : parameter_keys<DownwashOptions>())
    refuse_without_vehicles(world, key, "key", kind);
  return read_part<DownwashOptions>(TableSource(world), beside);
}

std::optional<RobotVehicle> read_vehicle(const TomlTable& agent, const Model& model, std::string_view world) {
  constexpr std::string_view key = "vehicle";
  const std::optional<Commands> commands = commands_of(model);
  refuse_without_vehicles(agent, key, "table", world);
  if (agent.has(key) && !commands) {
    agent.throw_invalid(key, fmt::format("no such table, the robot {} is no vehicle: those are {}",
                                         model.name(), robots_with_vehicles()));
  }
  if (!has_vehicles(agent, world) || !commands) return std::nullopt;
  if (commands == Commands::full_state && !agent.has(key)) return std::nullopt;  // it may remain a point mass

  const TomlTable at = agent.table_or_empty(key);
  const VehicleOfModel of_model = agent.registry().worlds.find(world)->of_model;
  const std::array<std::string_view, 3> beside = {"imu", "model", "body"};
  refuse_without_models(at, std::span(beside).last(2), world);
  RobotVehicle read;
  read.vehicle = read_part<Vehicle>(TableSource(at), std::span(beside).first(of_model ? 3 : 1));
  if (at.has("imu")) read.vehicle.imu = read_part<Imu>(TableSource(at.table("imu")));
  if (at.has("preset")) read.preset = at.text("preset", "a preset");
  if (at.has("body") && !at.has("model")) at.throw_invalid("model", "the file that body is of");
  if (at.has("model")) {
    read.model = ModelBody{read_model_file(at), at.has("body") ? at.text("body", "the name of a body") : ""};
    // A log is replayed without the world, and without the files that its models name.
    if (!at.from_disk()) return read;
    const Vehicle body = at.checked([&] { return of_model(read.vehicle, *read.model); });
    if (!at.has("mass")) read.vehicle.mass = body.mass;
    if (!at.has("inertia")) read.vehicle.inertia = body.inertia;
  }
  at.checked([&] { read.vehicle.check(); });
  return read;
}

ModelFile read_model_file(const TomlTable& at) {
  constexpr std::string_view expected = "the name of a model file, relative to this one";
  const std::string name = at.text("model", expected);
  if (name.empty()) at.throw_invalid("model", expected);
  try {
    return {.name = name, .text = at.file_text(name), .folder = at.file_folder(name)};
  } catch (const ScenarioError& error) {
    at.throw_invalid("model", fmt::format("{} ({})", expected, error.what()));
  }
}

void refuse_without_models(const TomlTable& at, std::span<const std::string_view> keys,
                           std::string_view world) {
  if (at.registry().worlds.find(world)->of_model) return;
  for (const std::string_view key : keys)
    if (at.has(key))
      at.throw_invalid(
          key, fmt::format(
                   "no such key in the world \"{}\", only in one that reads model files, as \"mujoco\" does",
                   world));
}

}  // namespace sightline
