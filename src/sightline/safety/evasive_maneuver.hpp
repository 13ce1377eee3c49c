/// Evasive trajectories out of an encirclement, for a robot that has no plan which is safe whatever the bodies do.
///
/// A way out is open loop: wait, then full thrust in one direction of G and one vertical speed, up to the
/// ceiling or down to the floor. It is simulated against bodies that pursue the robot, each straight at it
/// at its own speed, and judged by the least distance over the next 6 s minus the hard distance. The best
/// of a fixed set, of the present one and of variations of it is taken. Against bodies that do pursue in this
/// way the distance is never less than predicted: the rest of a plan is a plan. Against others nothing is guaranteed.
///
/// Allocates nothing, and is constant: what it remembers is held by the caller.
#pragma once

#include <array>
#include <limits>
#include <span>

#include "sightline/base/fixed.hpp"
#include "sightline/base/lane.hpp"
#include "sightline/safety/authority.hpp"

namespace sightline {

/// A plan, and how it comes to be remembered.
struct EvasiveManeuver {
  Vec2<double> along{};                                    ///< unit vector of G, or zero: no thrust
  double climb = 0.0;                                      ///< vertical speed [m/s]
  double wait = 0.0;                                       ///< before both begin [s]
  double left = -std::numeric_limits<double>::infinity();  ///< least distance less the hard one [m]
  double within = 0.0;                                     ///< for how long it leaves less than that [s]
  bool taken = false;  ///< it was flown in the period before, and is tried again
};

/// A body as a way out sees it.
struct Chaser {
  Vec3<double> p{};    ///< [m]
  Vec3<double> v{};    ///< of one that goes straight on [m/s]
  double speed = 0.0;  ///< at which it heads for the robot [m/s]
  double hard = 0.0;   ///< what is to be kept of it [m]
};

/// Where the robot is, and what it may not leave.
struct Arena {
  Vec3<double> p{};                 ///< [m]
  Vec2<double> v{};                 ///< horizontal velocity [m/s]
  std::array<Vec2<double>, 2> g{};  ///< two thrusts of G that add up [m/s^2]; zero: `disc` in every direction
  double disc = 0.0;                ///< [m/s^2]
  double floor = 0.0, ceiling = 0.0, world = 0.0;  ///< [m]
};

class EvasiveManeuvers {
 public:
  EvasiveManeuvers() = default;
  /// @param drag   c [1/s], >= 0
  /// @param climb  greatest vertical speed both ways [m/s], >= 0
  EvasiveManeuvers(double drag, double climb);

  /// The best way out. Where `enough` [m] are left by one, it need not be the best.
  /// @param before  the one that was taken, less the time since; looked at first
  EvasiveManeuver best(const Arena& arena, std::span<const Chaser> chasers, const EvasiveManeuver& before,
                       double enough) const noexcept;
  /// What a plan leaves [m].
  double left(const Arena& arena, std::span<const Chaser> chasers,
              const EvasiveManeuver& plan) const noexcept;

  /// Greatest acceleration along a unit vector, as a vector [m/s^2].
  static Vec2<double> thrust(const Arena& arena, const Vec2<double>& along) noexcept;

  static constexpr std::size_t headings = 16;
  /// The unit vectors that are tried.
  static Vec2<double> heading(std::size_t i) noexcept;

 private:
  using Pack = NativeLane;
  static constexpr std::size_t width = Pack::width;
  void judge(const Arena& arena, std::span<const Chaser> chasers,
             std::span<EvasiveManeuver, width> plans) const noexcept;

  struct Step {
    double h = 0.0, e = 1.0, E = 0.0,
           F = 0.0;  // [s]; of the velocity; what a velocity and an acceleration are worth
  };
  Step fine_, coarse_;
  double climb_ = 0.0;
  std::array<Vec2<double>, headings> heading_{};
};

}  // namespace sightline
