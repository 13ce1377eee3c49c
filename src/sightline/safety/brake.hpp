/// The input that gives a robot a velocity, whatever its model: how it holds, and how it lands.
///
/// The velocity that the robot has after a time tau under a held input u is linearised in u at u*,
///
///   q(u) = (v(x + tau f(x, u), u), turn rate),   q(u) ~ q(u*) + J (u - u*),
///
/// and u = argmin |q(u) - q_wanted|^2 + 1e-9 |u - u*|^2, within the limits. What a model cannot do is left out by
/// the least squares: a ground robot that is to land stands. For the multirotor q is affine in u, and v decays
/// about as e^{-t/tau}.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/model/model.hpp"

namespace sightline {

/// Allocates nothing once it is made.
class Brake {
 public:
  /// @param u_ref  u*, the input at rest (nu <= 16)
  /// @param tau    [s], > 0
  Brake(const Model& model, std::span<const double> u_ref, double tau);

  /// Writes the input (nu) that makes the velocity of the state x (nx) this one [m/s].
  /// @param turn_rate  to the left [rad/s]
  void operator()(std::span<const double> x, const Vec3<double>& velocity, std::span<const double> u_min,
                  std::span<const double> u_max, std::span<double> u, double turn_rate = 0.0) noexcept;

  static constexpr std::size_t inputs_max = 16;

 private:
  static constexpr std::size_t rows = 4;  // v and the turn rate
  std::array<double, rows> outcome(std::span<const double> x, std::span<const double> u) noexcept;

  Model model_;
  std::vector<double> u_ref_, trial_, rate_, soon_;
  double tau_;
};

}  // namespace sightline
