/// What the worlds of vehicles have in common: who flies in them, what ends them, and with which sentence.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/world/fleet.hpp"
#include "sightline/world/model_world.hpp"

namespace sightline {

/// A ModelWorld whose vehicles a Fleet moves. Targets, obstacles and robots that are no vehicles move as in a ModelWorld; delays, noise,
/// faults and presence are those of one. Wind, gusts and wakes are air that moves: an acceleration a is air at Vehicle::air(a), whose drag
/// accelerates the hovering vehicle by a; in flight the drag acts on the velocity through that air. So does the downwash of the other
/// vehicles (downwash.hpp). Commands come into force at whole milliseconds.
///
/// A vehicle that touches the ground at more than landing_speed_max, or another body, ends the world.
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

  /// The vehicle that is that robot; none for any other body.
  const Rotorcraft* rotorcraft(BodyId robot) const { return fleet_->rotorcraft(robot); }

 protected:
  /// What ended the world.
  struct Touch {
    BodyId a{}, b{};                          ///< a is a vehicle; b: index -1, what is no body of the team
    double t = 0.0, speed = 0.0;              ///< when [s], how fast [m/s]
    std::string_view surface = "the ground";  ///< what that is; outlives the world
  };

  /// @param kind   of the world, for refusals
  /// @param x0     states of all bodies, in the order of the team (nx)
  /// @param fleet  of that team and these vehicles
  /// @throws std::invalid_argument as ModelWorld; for a vehicle that starts below the ground or is asked to feel wind without drag; for
  /// a period that is no whole number of milliseconds
  VehicleWorld(std::string_view kind, const Team& team, std::vector<double> x0,
               const std::vector<RobotVehicle>& vehicles, std::unique_ptr<Fleet> fleet, PlantOptions plant,
               const SensorOptions& sensor);

  /// Before the bodies move on from t [s].
  virtual void before(double /*t*/) noexcept {}
  /// The first touch that there is at t [s].
  virtual std::optional<Touch> touch(double t) noexcept = 0;
  /// A body that was absent is there, or the other way round.
  virtual void came(BodyId /*body*/) noexcept {}
  virtual void left(BodyId /*body*/) noexcept {}

  Fleet& fleet() const noexcept { return *fleet_; }
  bool there(BodyId body) const noexcept;
  /// Position and velocity of a body.
  Sight<double> sight(BodyId body) const noexcept;

 private:
  std::unique_ptr<Fleet> fleet_;
  std::unique_ptr<ModelWorld> world_;
  std::vector<Presence> presence_;
  std::vector<double> rest_;  // inputs, for poses
  std::vector<Quaternion> attitudes_;
  std::optional<Touch> touch_;
};

}  // namespace sightline
