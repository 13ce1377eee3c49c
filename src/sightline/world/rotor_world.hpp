/// The simulated world of vehicles: robots that tilt, under flight controllers, in moving air.
#pragma once

#include "sightline/world/vehicle_world.hpp"

namespace sightline {

/// World whose vehicles are sightline's own rigid bodies, above the ground plane z = 0.
///
/// For contacts a vehicle is an upright cylinder of its radius and height; other bodies are points.
/// Contacts are checked at the end of each period. Two bodies that overlap at the start, or on
/// joining, can touch only after they have separated.
class RotorWorld final : public VehicleWorld {
 public:
  /// @param x0  states of all bodies, in team order (nx)
  /// @throws std::invalid_argument as VehicleWorld and Fleet
  RotorWorld(const Team& team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
             const PlantOptions& plant = {}, const SensorOptions& sensor = {});

 private:
  /// Two bodies that can touch; a is a vehicle.
  struct Pair {
    BodyId a, b;
    double radii, height;  ///< contact if the horizontal and the vertical distance are both below these [m]
    bool apart = false;    ///< they have been separated
  };

  std::optional<Touch> touch(double t) noexcept override;
  void came(BodyId body) noexcept override;
  Vec3<double> position(BodyId body) const noexcept;

  std::vector<Pair> pairs_;
};

}  // namespace sightline
