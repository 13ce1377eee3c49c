#include <fmt/format.h>

#include "sightline/base.hpp"
#include "sightline/mujoco.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_camera.hpp"
#include "worlds/mujoco/bodies.hpp"
#include "worlds/mujoco/renderer.hpp"
#include "worlds/mujoco/shape.hpp"

namespace sightline {

MujocoWorld::MujocoWorld(const Team& team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
                         const PlantOptions& plant, const SensorOptions& sensor,
                         const std::optional<ModelFile>& surroundings)
    : VehicleWorld("mujoco", team, std::move(x0), vehicles,
                   std::make_unique<Bodies>(team, vehicles, plant, surroundings), plant, sensor) {
  before(0.0);
  bodies().check_start(team);
}

void MujocoWorld::validate(const Team& team, std::span<const double> x0,
                           const std::vector<RobotVehicle>& vehicles,
                           const std::optional<ModelFile>& surroundings) {
  Bodies bodies(team, vehicles, {}, surroundings);
  const std::vector<double> u(size(team.nu()));
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    const double* const x = &x0[size(team.state_offset(body))];
    if (bodies.moves(body)) {
      bodies.begin(body, 0.0, x);
    } else {
      const Sight<double> seen = team.model(body).sight(x, u.data());
      bodies.place(body, seen.p, seen.v);
    }
  }
  bodies.check_start(team);
}

MujocoWorld::Bodies& MujocoWorld::bodies() const noexcept { return static_cast<Bodies&>(fleet()); }

bool MujocoWorld::apply(double t, std::span<const double> estimated, const Command& u, double period,
                        std::int64_t periods) noexcept {
  return VehicleWorld::apply(t, estimated, u, period, periods) && !bodies().failed();
}

void MujocoWorld::before(double) noexcept {
  for (int i = 0; i < team().bodies(); ++i) {
    const BodyId body{i};
    if (rotorcraft(body) != nullptr) continue;
    const Sight<double> seen = sight(body);
    bodies().place(body, seen.p, seen.v);
  }
}

std::optional<VehicleWorld::Touch> MujocoWorld::touch(double) noexcept {
  const auto& met = bodies().met();
  if (!met) return std::nullopt;
  return Touch{.a = met->a,
               .b = met->b,
               .t = static_cast<double>(met->tick) * rotorcraft_step,
               .speed = met->speed,
               .surface = met->surface};
}

void MujocoWorld::came(BodyId body) noexcept { bodies().set_there(body, true); }
void MujocoWorld::left(BodyId body) noexcept { bodies().set_there(body, false); }

std::string MujocoWorld::ended() const {
  return bodies().failed() ? bodies().failure() : VehicleWorld::ended();
}

Vehicle vehicle_of_mjcf(const Vehicle& vehicle, const ModelBody& model) {
  const mujoco::Shape shape = mujoco::shape_of(model);
  Vehicle read = vehicle;
  read.mass = shape.mass;
  read.inertia = shape.inertia;
  return read;
}

void add_mujoco(Registry& registry) {
  const auto make = [](const Scenario& scenario) -> std::unique_ptr<World> {
    return std::make_unique<MujocoWorld>(scenario.team, scenario.x0, scenario.vehicles,
                                         plant_options(scenario), sensor_options(scenario), scenario.model);
  };
  const auto check = [](const ScenarioSpec& scenario) {
    MujocoWorld::validate(scenario.team, scenario.x0, scenario.vehicles, scenario.model);
    // Only the machine can tell whether it renders.
    if (renders_pictures(scenario.vision)) (void)mujoco::make_renderer(scenario);
  };
  registry.worlds.add("mujoco", make, MovedBy::vehicles, vehicle_of_mjcf, mujoco::make_renderer, check);
}

}  // namespace sightline

extern "C" void sightline_add_mujoco(sightline::Registry& registry) { sightline::add_mujoco(registry); }
