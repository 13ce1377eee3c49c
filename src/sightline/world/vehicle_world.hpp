/// Common base of the worlds of vehicles: their fleet, and the contacts that end a run, with the
/// message.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/world/model_world.hpp"
#include "sightline/world/plant.hpp"
#include "sightline/world/vehicle.hpp"

namespace sightline {

class Fleet;
class Rotorcraft;

/// A ModelWorld whose vehicles a Fleet moves. Targets, obstacles and robots that are not vehicles
/// move as in a ModelWorld. Delays, noise, faults and presence are also as there. Wind, gusts and
/// wakes act as moving air. An acceleration a becomes air at the velocity Vehicle::air(a), whose
/// drag accelerates the hovering vehicle by a. In flight the drag acts on the velocity relative to
/// that air, and to the downwash of other vehicles (downwash.hpp). Commands come into force at
/// whole milliseconds.
///
/// The world ends if a vehicle touches the ground at more than landing_speed_max, or touches
/// another body.
class VehicleWorld : public World {
 public:
  ~VehicleWorld() override;

  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  void set_presence(std::span<const Presence> presence) noexcept override;
  void surround(const Surroundings& around) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  std::span<const double> truth() const noexcept override { return world_->truth(); }
  std::string ended() const override;

  /// The vehicle of this robot; nullptr for any other body.
  const Rotorcraft* rotorcraft(BodyId robot) const;

 protected:
  /// The contact that ended the world.
  struct Touch {
    BodyId a{}, b{};                          ///< a is a vehicle; b with index -1: not a body of the team
    double t = 0.0, speed = 0.0;              ///< time [s], speed [m/s]
    std::string_view surface = "the ground";  ///< name of b if it is not of the team; must outlive the world
  };

  /// @param kind   of the world, for error messages
  /// @param x0     states of all bodies, in team order (nx)
  /// @param fleet  built for this team and these vehicles
  /// @throws std::invalid_argument as ModelWorld; for a vehicle that starts below the ground, or
  /// without drag under wind; for a period that is not a whole number of milliseconds
  VehicleWorld(std::string_view kind, const Team& team, std::vector<double> x0,
               const std::vector<RobotVehicle>& vehicles, std::unique_ptr<Fleet> fleet, PlantOptions plant,
               const SensorOptions& sensor);

  /// Called before the bodies move on from t [s].
  virtual void before(double /*t*/) noexcept {}
  /// The first contact at t [s], if any.
  virtual std::optional<Touch> touch(double t) noexcept = 0;
  /// Called when an absent body joins; left(), when a present body leaves.
  virtual void came(BodyId /*body*/) noexcept {}
  virtual void left(BodyId /*body*/) noexcept {}

  Fleet& fleet() const noexcept { return *fleet_; }
  bool there(BodyId body) const noexcept;
  /// Pose of a body in G, and its velocity under zero inputs.
  Sight<double> sight(BodyId body) const noexcept;

 private:
  std::unique_ptr<Fleet> fleet_;
  std::unique_ptr<ModelWorld> world_;
  std::vector<Presence> presence_;
  std::vector<double> rest_;  // zero inputs (nu), for sight()
  std::vector<Quaternion> attitudes_;
  std::optional<Touch> touch_;
};

}  // namespace sightline
