/// Evasive trajectories for a surrounded robot: no plan is safe under every motion of the bodies.
///
/// A manoeuvre is open loop: wait, then full thrust in one direction of G and one vertical speed,
/// up to the ceiling or down to the floor. It is simulated against bodies that pursue the robot,
/// each straight at it at its own speed. Its value is the least distance over the next 6 s minus
/// the hard distance. The best of a fixed set, of the previous manoeuvre and of its variations is
/// taken.
///
/// Against bodies that do pursue in this way the distance is never less than predicted, since the
/// rest of a plan is a plan. Against others there is no guarantee.
///
/// Allocates nothing, and is constant: the caller stores the manoeuvre.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"

namespace sightline {

/// A body in the simulation of a manoeuvre.
struct Chaser {
  Vec3<double> p{};    ///< [m]
  Vec3<double> v{};    ///< velocity of a body that flies straight on [m/s]
  double speed = 0.0;  ///< speed at which it pursues the robot [m/s]
  double hard = 0.0;   ///< hard distance [m]
};

/// The robot's state, thrusts and bounds.
struct Arena {
  Vec3<double> p{};                 ///< [m]
  Vec2<double> v{};                 ///< horizontal velocity [m/s]
  std::array<Vec2<double>, 2> g{};  ///< two thrusts of G that add up [m/s^2]; zero: `disc` in any direction
  double disc = 0.0;                ///< radius of accelerations [m/s^2]
  double floor = 0.0, ceiling = 0.0, world = 0.0;  ///< [m]
};

class EvasiveManeuvers {
 public:
  EvasiveManeuvers() = default;
  /// @param drag   c [1/s], >= 0
  /// @param climb  greatest vertical speed both ways [m/s], >= 0
  EvasiveManeuvers(double drag, double climb);

  /// The best manoeuvre. Stops at a manoeuvre that leaves `enough` [m], which may not be the best.
  /// @param before  the previous manoeuvre, less the time since; tried first
  EvasiveManeuver best(const Arena& arena, std::span<const Chaser> chasers, const EvasiveManeuver& before,
                       double enough) const noexcept;
  /// The least distance of a manoeuvre, less the hard distance [m].
  double left(const Arena& arena, std::span<const Chaser> chasers,
              const EvasiveManeuver& plan) const noexcept;

  /// Greatest acceleration along a unit vector, as a vector [m/s^2].
  static Vec2<double> thrust(const Arena& arena, const Vec2<double>& along) noexcept;

  static constexpr std::size_t headings = 16;
  /// Unit vectors of the fixed set.
  static Vec2<double> heading(std::size_t i) noexcept;

 private:
  using Pack = NativeLane;
  static constexpr std::size_t width = Pack::width;
  void judge(const Arena& arena, std::span<const Chaser> chasers,
             std::span<EvasiveManeuver, width> plans) const noexcept;

  struct Step {
    double h = 0.0, e = 1.0, E = 0.0,
           F = 0.0;  // [s]; decay of the velocity; effects of a velocity and an acceleration
  };
  Step fine_, coarse_;
  double climb_ = 0.0;
  std::array<Vec2<double>, headings> heading_{};
};

}  // namespace sightline
