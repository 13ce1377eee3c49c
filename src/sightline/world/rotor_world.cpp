#include <cmath>

#include "sightline/base.hpp"
#include "sightline/world/fleet.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

class RotorFleet final : public Fleet {
 public:
  using Fleet::Fleet;

 private:
  void advance(std::int64_t steps) noexcept override {
    pool_->share(static_cast<int>(crafts_.size()), [&](int i, int) noexcept {
      Craft& craft = crafts_[at(i)];
      for (std::int64_t k = 0; craft.steered && k < steps; ++k) craft.flown.step(craft.commands, craft.air);
    });
  }
};

}  // namespace

RotorWorld::RotorWorld(const Team& team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
                       const PlantOptions& plant, const SensorOptions& sensor)
    : VehicleWorld("rotors", team, std::move(x0), vehicles,
                   std::make_unique<RotorFleet>(team, vehicles, plant), plant, sensor) {
  for (const RobotVehicle& one : vehicles) {
    for (int i = 0; i < team.bodies(); ++i) {
      const BodyId other{i};
      const Rotorcraft* const craft = rotorcraft(other);
      if (other == one.robot || (craft != nullptr && i < one.robot.index)) continue;
      const double radius = craft != nullptr ? craft->vehicle().radius : 0.0;
      const double height = craft != nullptr ? craft->vehicle().height : 0.0;
      pairs_.push_back({one.robot, other, one.vehicle.radius + radius, 0.5 * (one.vehicle.height + height)});
    }
  }
}

void RotorWorld::came(BodyId body) noexcept {
  for (Pair& pair : pairs_) {
    if (pair.a == body || pair.b == body) pair.apart = false;
  }
}

Vec3<double> RotorWorld::position(BodyId body) const noexcept {
  if (const Rotorcraft* const craft = rotorcraft(body)) return craft->body().p;
  return sight(body).p;
}

std::optional<RotorWorld::Touch> RotorWorld::touch(double t) noexcept {
  for (int i = 0; i < team().bodies(); ++i) {
    const Rotorcraft* const craft = rotorcraft(BodyId{i});
    if (craft != nullptr && there(BodyId{i}) && craft->crash_speed() > 0)
      return Touch{.a = BodyId{i}, .b = BodyId{-1}, .t = t, .speed = craft->crash_speed()};
  }
  for (Pair& pair : pairs_) {
    if (!there(pair.a) || !there(pair.b)) continue;
    const Vec3<double> r = position(pair.a) - position(pair.b);
    const bool touches = norm(r.x, r.y) < pair.radii && std::abs(r.z) < pair.height;
    if (touches && pair.apart) return Touch{.a = pair.a, .b = pair.b, .t = t};
    pair.apart = pair.apart || !touches;
  }
  return std::nullopt;
}

}  // namespace sightline
