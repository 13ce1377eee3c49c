/// The simulated world of vehicles: robots that tilt, under flight controllers, in moving air.
#pragma once

#include "sightline/world/vehicle_world.hpp"

namespace sightline {

/// Its vehicles are rigid bodies of our own, over the plane z = 0.
///
/// A vehicle is an upright cylinder to others, of its radius and height; bodies that are no vehicles touch as points. Touches are looked
/// for at the end of each period. Who overlaps at the start, or on joining, touches when they have been apart once.
class RotorWorld final : public VehicleWorld {
 public:
  /// @param x0  states of all bodies, in the order of the team (nx)
  /// @throws std::invalid_argument as VehicleWorld and Fleet
  RotorWorld(const Team& team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
             const PlantOptions& plant = {}, const SensorOptions& sensor = {});

 private:
  /// Two bodies that can touch; the first is a vehicle.
  struct Pair {
    BodyId a, b;
    double radii, height;  ///< nearer than both, they touch [m]
    bool apart = false;    ///< they have been
  };

  std::optional<Touch> touch(double t) noexcept override;
  void came(BodyId body) noexcept override;
  Vec3<double> position(BodyId body) const noexcept;

  std::vector<Pair> pairs_;
};

}  // namespace sightline
