/// Where a body will be along the horizon, as whoever plans its way predicts it: all that subteams exchange.
#pragma once

#include <vector>

#include "sightline/model/frames.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// A plain message: who, from when, in which steps, and what is seen of it there.
struct Prediction {
  BodyId who;
  double time = 0.0;                       ///< of the first sight [s]
  double h = 0.0;                          ///< between two sights [s], > 0
  std::vector<Sight<double>> sights = {};  ///< N + 1; empty: nothing is predicted

  /// Whether to use it at t for a body that is at p: sent less than its own length ago or ahead, and at most
  /// `astray` [m] from there.
  bool holds(double t, const Vec3<double>& p) const noexcept;
  static constexpr double astray = 1.0;
  /// What is seen at its stage k >= 0 of a horizon that begins at t, of steps as long: between two sights the line
  /// between them, before the first and after the last its velocity goes on.
  Sight<double> at(double t, int k) const noexcept;
  /// Whether every number is finite.
  bool is_finite() const noexcept;
};

}  // namespace sightline
