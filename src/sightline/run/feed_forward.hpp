/// The input by which a robot's model follows its reference, for u* in its cost.
///
/// R holds a plan back from the inputs that a moving reference needs: against u* = 0 the plan cuts a circle, the more the less
/// an input does. With velocity v, acceleration a and turn r of the reference, from its poses 0.1 s before and after,
///
///   u* = u_ref + argmin_u min_z |(C z + E u, D z + B u, F u) - (v, a, r)|^2
///
/// where C, D are what the states that are velocities (z) change of the robot's velocity and acceleration, E, B, F what its inputs do
/// to these and to how fast it turns once the lags are over. What a robot cannot do is left out by the least squares, and r where no
/// heading is asked of it. Numbers are those of the robot at rest, by components of V where it turns: drag, lags and gains count, the
/// acceleration that a turn makes of a velocity does not.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sightline/ocp/team.hpp"

namespace sightline {

/// Of one robot. Allocates nothing once it is made.
class FeedForward {
 public:
  explicit FeedForward(const Agent& agent);

  /// Writes u* (nu) at t [s].
  /// @param x_ref  as it is then; where it is no number, u* is u_ref
  /// @param d      the robot's heading
  void operator()(const Reference& x_ref, double t, const Vec2<double>& d, std::span<double> u) noexcept;

  static constexpr double difference = 0.1;  ///< of times at which the reference is looked at [s]

 private:
  static constexpr std::size_t rows = 7;  // v, a and r

  Model model_;
  std::vector<double> u_ref_, x_;
  std::vector<std::array<double, rows>> gain_;  // of each input, of v, a and r
};

}  // namespace sightline
