/// The constants of a Barrier, and the prediction of one period by its model.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"
#include "sightline/base/bounded.hpp"
#include "sightline/model.hpp"
#include "sightline/safety/authority.hpp"
#include "sightline/safety/escape.hpp"
#include "sightline/safety/evasive_maneuver.hpp"
#include "sightline/safety/zone.hpp"

namespace sightline {

inline constexpr std::size_t most_neighbours = Barrier::most_neighbours;
inline constexpr double far_away = 1e6;  // [m] bodies farther away are ignored

/// The next sampled state, as far as the filter depends on it.
struct NextState {
  Vec3<double> p;  // position, as BarrierLaw::settled()
  Vec2<double> d, v;
  double beside = 0.0;  // height less the height at which the robot comes to rest [m]
};

/// The motion of one period under a command.
struct Flown {
  Bounded<Vec3<double>, EscapePlans::most_parts> between;  // positions at the ends of all steps but the last
  NextState after;
};

/// Braking to rest along a straight line.
struct Stop {
  double time = 0.0, length = 0.0;  // [s], a whole number of periods; [m]
  double next_speed = 0.0;          // after one period [m/s]
};

/// A bound of the horizontal position: n . p + offset >= 0.
struct BoundPlane {
  Vec2<double> n;  // unit vector
  double offset;   // [m]
  Wall wall;
};

struct BarrierLaw {
  BarrierLaw(const Model& robot, const Authority& ability, double period, const BarrierOptions& given);

  /// The state under the command u (nu) after the period.
  NextState next(std::span<const double> x, std::span<const double> u) const noexcept;
  Flown flown(std::span<const double> x, std::span<const double> u) const noexcept;
  static constexpr double still = 1e-6;  ///< a robot that is slower stands [m/s]
  /// The plan of a robot that drives along its heading: it brakes with a part of the acceleration,
  /// and in the last period with the less that stops it at the sample.
  Stop stop(double speed, double part) const noexcept;
  /// Replaces the height by that at which the robot comes to rest without commands.
  Sight<double> settled(Sight<double> self) const noexcept;
  /// Deceleration that plans have left against the residual acceleration [m/s^2].
  double braking(double part) const noexcept;
  /// Time until a velocity towards a bound is zero [s].
  double stopping_time(double away, double part) const noexcept;
  /// Distance to a plane when the velocity towards it is zero, after braking straight away from it
  /// with a part of the acceleration, or along the heading [m]; at most the distance now.
  double braked(const BoundPlane& plane, const Vec3<double>& p, const Vec2<double>& v,
                double part) const noexcept;
  /// Makes the smallest change of u that leads to the wanted horizontal velocity and height after
  /// the period, within the limits.
  void reach_for(std::span<const double> x, const std::array<double, 3>& wanted,
                 std::span<const double> u_min, std::span<const double> u_max,
                 std::span<double> u) const noexcept;

  Model model;
  BarrierOptions options;              // bounds less their margins
  std::vector<ForbiddenPiece> pieces;  // of all zones, with their margins
  double dt;                           // [s]
  int parts;                           // integration steps of a period
  Authority can;
  double b;  // acceleration that plans use [m/s^2]
  /// Deviation from the predicted state by the residual acceleration.
  struct Deviation {
    double p, v;  // [m], [m/s]
  };
  Deviation predicted, next_predicted;  // where the present command and the next one take effect
  EscapePlans plans;
  double ample;  // upper bound on the loss of a plan's reserve in a period [m]
  EvasiveManeuvers maneuvers;
  /// Thrusts of plans for several neighbours, in V or G [m/s^2].
  std::array<Vec2<double>, EvasiveManeuvers::headings> joint;
};

}  // namespace sightline
