/// The input that gives a robot of any model a wanted velocity, to hold position or to land.
///
/// The velocity after a time tau under a held input u is linearised in u at u*,
///
///   q(u) = (v(x + tau f(x, u), u), turn rate),   q(u) ~ q(u*) + J (u - u*),
///
/// and u = argmin |q(u) - q_wanted|^2 + 1e-9 |u - u*|^2, clamped to the limits. Least squares
/// leaves out what a model cannot do: a ground robot that is to land stands. For the multirotor q
/// is affine in u, and v decays approximately as e^{-t/tau}.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/model/model.hpp"

namespace sightline {

/// Allocates only during construction.
class Brake {
 public:
  /// @param u_ref  u*, the input at rest (nu <= 16)
  /// @param tau    [s], > 0
  Brake(const Model& model, std::span<const double> u_ref, double tau);

  /// Writes the input (nu) that leads from the state x (nx) to this velocity [m/s] in G.
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
