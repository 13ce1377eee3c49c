/// The input with which a robot's model follows its reference, used as u* in its cost.
///
/// R penalises the inputs that a moving reference needs. With u* = 0 the plan cuts corners of a
/// circle, and more so for inputs with small gains. With velocity v, acceleration a and turn rate r
/// of the reference, from its poses 0.1 s before and after,
///
///   u* = u_ref + argmin_u min_z |(C z + E u, D z + B u, F u) - (v, a, r)|^2
///
/// C and D are the effects of the velocity states z on the robot's velocity and acceleration. E, B
/// and F are the effects of its inputs on velocity, acceleration and turn rate after the lags have
/// settled. Least squares leaves out what the robot cannot do. r is left out if the cost has no
/// heading. The matrices are those of the robot at rest, in V if the robot turns. They include
/// drag, lags and gains, but not the acceleration of a velocity that turns with the heading.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// Feed-forward of one robot. Allocates only during construction.
class FeedForward {
 public:
  explicit FeedForward(const Agent& agent);

  /// Writes u* (nu) at t [s].
  /// @param x_ref  reference in force at t; where it is not finite, u* is u_ref
  /// @param d      the robot's heading
  void operator()(const Reference& x_ref, double t, const Vec2<double>& d, std::span<double> u) noexcept;

  static constexpr double difference = 0.1;  ///< between times at which the reference is evaluated [s]

 private:
  static constexpr std::size_t rows = 7;  // v, a and r

  Model model_;
  std::vector<double> u_ref_, x_;
  std::vector<std::array<double, rows>> gain_;  // of each input, with respect to v, a and r
};

}  // namespace sightline
