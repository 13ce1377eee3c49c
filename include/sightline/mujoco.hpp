/// A vehicle world with the rigid bodies and contacts of MuJoCo. Link sightline::mujoco.
///
///   Registry registry;
///   add_mujoco(registry);                              // [world] kind = "mujoco"
///   return command_line(argc, argv, registry);
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/registry.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

/// The vehicles of RotorWorld, including flight controllers, rotors and air, moved by MuJoCo's
/// integrator "Euler" in steps of 1 ms. Without contacts the two worlds agree to rounding.
///
/// The ground is the plane z = 0. A vehicle stands on the ground with p_z = 0, as a cylinder of its
/// radius and half its height. To other bodies a vehicle is a cylinder of its radius and height
/// about p that tilts with it. To a vehicle, bodies that are no vehicles are points. A body of a
/// model file has the geoms of that file instead, for both purposes. Each step evaluates the
/// contacts. A touch of another body ends the world, and so does a touch of the ground or the
/// surroundings at more than landing_speed_max. MuJoCo's contact forces handle slower touches.
/// Bodies that overlap at the start or on joining count as touching only after they have separated
/// once.
class MujocoWorld final : public VehicleWorld {
 public:
  /// @param x0            states of all bodies, in the order of the team (nx)
  /// @param surroundings  an MJCF with the surroundings
  /// @throws std::invalid_argument as VehicleWorld, Fleet and validate()
  MujocoWorld(const Team& team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
              const PlantOptions& plant = {}, const SensorOptions& sensor = {},
              const std::optional<ModelFile>& surroundings = {});

  /// Compiles the model of the team, and checks its contacts at the start, without a world.
  /// @throws std::invalid_argument "model = ..." with MuJoCo's message for a rejected MJCF; for a
  ///   vehicle that starts within the ground or the surroundings
  static void validate(const Team& team, std::span<const double> x0,
                       const std::vector<RobotVehicle>& vehicles,
                       const std::optional<ModelFile>& surroundings);

  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  /// A touch, or the reason why MuJoCo could not continue.
  std::string ended() const override;

 private:
  class Bodies;

  Bodies& bodies() const noexcept;
  void before(double t) noexcept override;
  std::optional<Touch> touch(double t) noexcept override;
  void came(BodyId body) noexcept override;
  void left(BodyId body) noexcept override;
};

/// Mass and inertia of a body of an MJCF, with all bodies fixed to it, about their centre of mass.
/// @throws std::invalid_argument "model = ..." if MuJoCo rejects the MJCF, "body = ..." if the body
///   cannot be a vehicle
Vehicle vehicle_of_mjcf(const Vehicle& vehicle, const ModelBody& model);

/// Adds [world] kind = "mujoco".
/// @throws std::invalid_argument if another world has that name
void add_mujoco(Registry& registry);

}  // namespace sightline
