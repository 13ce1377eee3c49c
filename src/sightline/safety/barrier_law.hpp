/// The constants of a Barrier, and the prediction of one period by its model.
#pragma once

#include <array>
#include <cmath>
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

/// What follows late of a robot whose horizontal acceleration has a lag.
struct Lagging {
  Vec2<double> a;     // acceleration, in G [m/s^2]
  double rate = 0.0;  // of the heading [rad/s]
};

/// The next sampled state, as far as the filter depends on it.
struct NextState {
  Vec3<double> p;  // position, as BarrierLaw::settled()
  Vec2<double> d, v;
  double beside = 0.0;  // height less the height at which the robot comes to rest [m]
  Lagging lagging{};
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
  Lagging lagging(std::span<const double> x, const Sight<double>& seen) const noexcept;
  /// The point p + tau v, which follows the commands at once. The position is a low-pass of it.
  struct Point {
    Vec3<double> p;
    Vec2<double> v;
  };
  Point leading(const Vec3<double>& p, const Vec2<double>& v, const Lagging& late) const noexcept;
  /// Bound on the deviation from a predicted leading() point.
  struct Deviation {
    double p = 0.0, v = 0.0;  // [m], [m/s]
  };
  using Outcome = std::array<double, 3>;
  /// The horizontal velocity, or the acceleration if that lags, and the height after a period with
  /// one commanded acceleration and a climb `rise` [m].
  Outcome outcome_of(const Sight<double>& self, const Lagging& late, const Vec2<double>& a,
                     double rise) const noexcept;
  /// The same for a tilt with a lag, if the command keeps its direction in V while the heading turns.
  /// @param coasting  the next state without commands
  Outcome outcome_of_held(const Sight<double>& self, const NextState& coasting,
                          const Vec2<double>& a) const noexcept;
  /// Reserve that a plan must certainly leave [m]: the check of commands and the bound use up to one
  /// half of the margin, the motion between samples the other.
  double proven_least() const noexcept { return -0.5 * options.margin; }
  /// Speed that bounds all later effects of a height and a yaw rate that settle [m/s].
  double settling(double beside, double rate) const noexcept {
    return per_beside * std::abs(beside) + per_rate * std::abs(rate);
  }
  /// What they add to the leading() point of a plan: the climb moves it at once by tau times the
  /// velocity that it adds.
  Deviation settling_of_leading(double beside, double rate) const noexcept {
    return {can.thrust_lag * per_beside * std::abs(beside), settling(beside, rate)};
  }
  /// Deceleration that plans have left against the residual acceleration [m/s^2].
  double braking(double part) const noexcept;
  /// Time until a velocity towards a bound is zero [s].
  double stopping_time(double away, double part) const noexcept;
  /// Distance to a plane when the velocity towards it is zero, after braking straight away from it
  /// with a part of the acceleration, or along the heading [m]; at most the distance now.
  double braked(const BoundPlane& plane, const Point& from, const Deviation& settling,
                double part) const noexcept;
  /// Part of settling_of_leading() that counts for a plan of this velocity away from a wall: what
  /// settles until the robot has braked. Thus a robot at a wall may climb.
  double settling_part(double away, double part) const noexcept {
    return can.thrust_lag > 0 && can.climb_lag > 0
               ? 1.0 - std::exp(-stopping_time(away, part) / can.climb_lag)
               : 0.0;
  }
  /// Makes the smallest change of u that leads to the wanted outcome, within the limits.
  void reach_for(std::span<const double> x, const Outcome& wanted, std::span<const double> u_min,
                 std::span<const double> u_max, std::span<double> u) const noexcept;

  Model model;
  BarrierOptions options;              // bounds less their margins
  std::vector<ForbiddenPiece> pieces;  // of all zones, with their margins
  double dt;                           // [s]
  int parts;                           // integration steps of a period
  Authority can;
  double b;  // acceleration that plans use [m/s^2]
  /// By the residual acceleration, where the present command and the next one take effect.
  Deviation predicted, next_predicted;
  EscapePlans plans;
  double per_beside = 0.0, per_rate = 0.0;  // settling() of 1 m and 1 rad/s
  double ample;                             // upper bound on the loss of a plan's reserve in a period [m]
  EvasiveManeuvers maneuvers;
  /// Thrusts of plans for several neighbours, in V or G [m/s^2].
  std::array<Vec2<double>, EvasiveManeuvers::headings> joint;
};

}  // namespace sightline
