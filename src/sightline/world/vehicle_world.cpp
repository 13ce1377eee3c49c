#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/world/fleet.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

void check_period(std::string_view kind, double period) {
  const double steps = period / rotorcraft_step;
  if (std::abs(steps - std::round(steps)) > 1e-6 || std::round(steps) < 1)
    throw_invalid(
        "world.kind = \"{}\" moves in steps of {} s, but the period is {} s, expected a whole number of "
        "steps",
        kind, rotorcraft_step, period);
}

/// Rejects wind on an axis without drag, where it could not act.
void check_wind(const Vehicle& vehicle, std::string_view name, const PlantOptions& plant) {
  const Disturbances& d = plant.disturbances;
  const Vec3<double> drag = vehicle.hover_drag();
  const bool everywhere = d.gust_sigma > 0, level = everywhere || d.airflow.amplitude > 0;
  const bool calm = (drag.x > 0 || !(level || d.wind.x != 0 || d.wind.y != 0)) &&
                    (drag.z > 0 || !(everywhere || d.wind.z != 0 || plant.downwash.scale > 0));
  if (!calm)
    throw_invalid(
        "vehicle.drag of {} is [{}, {}, {}] N s/m, expected one that wind, gusts, wakes and downwash can "
        "push",
        name, vehicle.drag.x, vehicle.drag.y, vehicle.drag.z);
}

}  // namespace

void validate(std::string_view kind, const Team& team, std::span<const double> x0,
              const std::vector<RobotVehicle>& vehicles, const PlantOptions& plant) {
  check_period(kind, plant.period);
  const std::vector<double> u(size(team.nu()));
  for (const RobotVehicle& one : vehicles) {
    check_wind(one.vehicle, team.name(one.robot), plant);
    const double* const x = &x0[size(team.state_offset(one.robot))];
    if (const double z = team.model(one.robot).sight(x, u.data()).p.z; z < 0)
      throw_invalid("{} starts at a height of {} m, expected one above the ground, at least 0 m",
                    team.name(one.robot), z);
  }
}

VehicleWorld::VehicleWorld(std::string_view kind, const Team& team, std::vector<double> x0,
                           const std::vector<RobotVehicle>& vehicles, std::unique_ptr<Fleet> fleet,
                           PlantOptions plant, const SensorOptions& sensor)
    : fleet_(std::move(fleet)) {
  plant.dynamics = fleet_.get();
  world_ = std::make_unique<ModelWorld>(team, std::move(x0), plant, sensor);
  presence_.resize(size(team.bodies()), Presence::steered);
  rest_.resize(size(team.nu()));
  attitudes_.resize(presence_.size(), no_attitude);
  validate(kind, team, world_->x(), vehicles, plant);
}

VehicleWorld::~VehicleWorld() = default;

const Rotorcraft* VehicleWorld::rotorcraft(BodyId robot) const { return fleet_->rotorcraft(robot); }

void VehicleWorld::surround(const Surroundings& around) noexcept { world_->surround(around); }

void VehicleWorld::set_presence(std::span<const Presence> presence) noexcept {
  world_->set_presence(presence);
  for (std::size_t i = 0; i < std::min(presence.size(), presence_.size()); ++i) {
    const Presence was = std::exchange(presence_[i], presence[i]);
    const BodyId body{static_cast<int>(i)};
    if (was == Presence::absent && presence[i] != Presence::absent) came(body);
    if (was != Presence::absent && presence[i] == Presence::absent) left(body);
  }
}

/// Measurements of the models' world, with the attitudes of the vehicles.
Measured VehicleWorld::measure(double t) noexcept {
  Measured now = world_->measure(t);
  for (std::size_t i = 0; i < attitudes_.size(); ++i) {
    const Rotorcraft* const craft = rotorcraft(BodyId{static_cast<int>(i)});
    if (craft != nullptr) attitudes_[i] = craft->body().q;
  }
  now.attitudes = attitudes_;
  return now;
}

bool VehicleWorld::apply(double t, std::span<const double> estimated, const Command& u, double period,
                         std::int64_t periods) noexcept {
  for (std::int64_t k = 0; k < periods; ++k) {
    before(t + static_cast<double>(k) * period);
    if (!world_->apply(t + static_cast<double>(k) * period, estimated, u, period, 1)) return false;
    touch_ = touch(t + static_cast<double>(k + 1) * period);
    if (touch_) return false;
  }
  return true;
}

bool VehicleWorld::there(BodyId body) const noexcept { return presence_[at(body)] != Presence::absent; }

Sight<double> VehicleWorld::sight(BodyId body) const noexcept {
  const Team& all = world_->team();
  const double* const x = &world_->x()[size(all.state_offset(body))];
  // Poses do not depend on inputs.
  return all.model(body).sight(x, rest_.data() + all.input_offset(body));
}

std::string VehicleWorld::ended() const {
  if (!touch_) return {};
  const Team& all = world_->team();
  if (touch_->b.index < 0) {
    return fmt::format("{} touched {} at {:.3f} s with {:.2f} m/s, expected at most {} m/s",
                       all.name(touch_->a), touch_->surface, touch_->t, touch_->speed, landing_speed_max);
  }
  return fmt::format("{} and {} touched at {:.3f} s", all.name(touch_->a), all.name(touch_->b), touch_->t);
}

}  // namespace sightline
