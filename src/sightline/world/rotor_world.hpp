/// The simulated world of vehicles: robots that tilt, under flight controllers, in moving air.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/world/model_world.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "sightline/world/vehicle.hpp"

namespace sightline {

/// A ModelWorld whose vehicles are moved by rotors. What is measured of a vehicle is the state of its planning model, as the rigid
/// body shows it:
///
///   p            of the centre of mass
///   d or psi     of the body's x axis, seen from above
///   v_f, v_s     velocity along d and to its left, level;   v_z   upward;   r   rate of psi
///   a_f, a_s     g tan(tilt) along d and to its left: the acceleration of a thrust that holds the height
///
/// Targets, obstacles and robots that are no vehicles move as in a ModelWorld; delays, noise, faults and presence are those of one.
/// Wind, gusts and wakes are air that moves: an acceleration a is air at Vehicle::air(a), whose drag accelerates the hovering vehicle by
/// a; in flight the drag acts on the velocity through that air. Commands come into force at whole milliseconds.
///
/// A vehicle that touches the ground at more than landing_speed_max, or another body, ends the world. Bodies that are no vehicles
/// touch as points. Who overlaps at the start, or on joining, touches when they have been apart once.
class RotorWorld final : public World {
 public:
  /// @param x0  states of all bodies, in the order of the team (nx)
  /// @throws std::invalid_argument as ModelWorld; for a vehicle that cannot be, of a robot that cannot be one, that starts below the
  /// ground or is asked to feel wind without drag; for a period that is no whole number of milliseconds
  RotorWorld(Team team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
             PlantOptions plant = {}, const SensorOptions& sensor = {});
  ~RotorWorld() override;

  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  void set_presence(std::span<const Presence> presence) noexcept override;
  Measured measure(double t) noexcept override { return world_->measure(t); }
  bool apply(double t, std::span<const double> believed, std::span<const double> u, double period,
             std::int64_t periods) noexcept override;
  std::string ended() const override;

  /// The vehicle that is that robot; none for any other body.
  const Rotorcraft* rotorcraft(BodyId robot) const;

 private:
  class Fleet;
  /// Two bodies that can touch; the first is a vehicle.
  struct Pair {
    BodyId a, b;
    double radii, height;  ///< nearer than both, they touch [m]
    bool apart = false;    ///< they have been
  };
  /// What ended the world.
  struct Touch {
    BodyId a{}, b{};  ///< b: index -1, the ground
    double t = 0.0, speed = 0.0;
  };

  Vec3<double> position(BodyId body) const noexcept;
  std::optional<Touch> touch(double t) noexcept;

  std::unique_ptr<Fleet> fleet_;
  std::unique_ptr<ModelWorld> world_;
  std::vector<Pair> pairs_;
  std::vector<Presence> presence_;
  std::vector<double> rest_;  // inputs, for poses
  std::optional<Touch> touch_;
};

}  // namespace sightline
