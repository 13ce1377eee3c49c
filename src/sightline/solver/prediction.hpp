/// Predicted motion of one body along the horizon: the only data that subteams exchange.
#pragma once

#include <vector>

#include "sightline/model/frames.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// Prediction message: the body, the time of the first sample, the step and the predicted Sights.
struct Prediction {
  BodyId who;
  double time = 0.0;                       ///< time of the first Sight [s]
  double h = 0.0;                          ///< step between two Sights [s], > 0
  std::vector<Sight<double>> sights = {};  ///< N + 1 Sights; empty: no prediction

  /// Whether the prediction is usable at time t [s] for a body at p [m]: |t - time| is less than
  /// its length, and it deviates from p by at most `astray` [m].
  bool holds(double t, const Vec3<double>& p) const noexcept;
  static constexpr double astray = 1.0;
  /// Predicted Sight at time t + k h [s], stage k >= 0. Interpolates linearly between two Sights;
  /// before the first and after the last Sight the velocity is constant.
  Sight<double> at(double t, int k) const noexcept;
  /// Whether the time and all numbers of all Sights are finite.
  bool is_finite() const noexcept;
};

}  // namespace sightline
