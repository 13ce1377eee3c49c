/// The world of vehicles with the rigid bodies and contacts of MuJoCo. Link sightline::mujoco.
///
///   Registry registry;
///   add_mujoco(registry);                              // [world] kind = "mujoco"
///   return command_line(argc, argv, registry);
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/scenario/registry.hpp"
#include "sightline/world/vehicle_world.hpp"

namespace sightline {

/// Vehicles as in RotorWorld, flight controllers, rotors and air included, moved by MuJoCo's integrator "Euler" in steps of 1 ms. Where
/// nothing touches, the two worlds agree to rounding.
///
/// The ground is the plane z = 0. A vehicle stands on it with p_z = 0, as a cylinder of its radius and half its height; to other bodies it is
/// a cylinder of its radius and height about p that tilts with it, and they are points to it. A body of a model file has the geoms of
/// that file instead, for both. Contacts are looked at in each step: a touch of another body ends the world, and so does one of the
/// ground, or of what else there is, at more than landing_speed_max; a slower one MuJoCo's contact forces carry. Who overlaps at the
/// start, or on joining, touches when they have been apart once.
class MujocoWorld final : public VehicleWorld {
 public:
  /// @param x0            states of all bodies, in the order of the team (nx)
  /// @param surroundings  an MJCF: what else there is
  /// @throws std::invalid_argument as VehicleWorld and Fleet; "model = ..." with MuJoCo's sentence for an MJCF that it refuses; for a
  /// vehicle that starts within the ground or within what else there is
  MujocoWorld(const Team& team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
              const PlantOptions& plant = {}, const SensorOptions& sensor = {},
              const std::optional<ModelFile>& surroundings = {});

  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  /// A touch, or why MuJoCo could not go on.
  std::string ended() const override;

 private:
  class Bodies;

  Bodies& bodies() const noexcept;
  void before(double t) noexcept override;
  std::optional<Touch> touch(double t) noexcept override;
  void came(BodyId body) noexcept override;
  void left(BodyId body) noexcept override;
};

/// Mass and inertia of a body of an MJCF, with all that is fixed to it, about their centre of mass.
/// @throws std::invalid_argument "model = ..." for an MJCF that MuJoCo refuses, "body = ..." for a body that cannot be a vehicle
Vehicle vehicle_of_mjcf(const Vehicle& vehicle, const ModelBody& model);

/// Adds [world] kind = "mujoco".
/// @throws std::invalid_argument where another world has that name
void add_mujoco(Registry& registry);

}  // namespace sightline
