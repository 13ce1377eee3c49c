/// Measurement model of planar robots: range and bearing to another body, with traced derivatives.
#pragma once

#include <array>
#include <span>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"

namespace sightline {

/// Range and bearing from a sensor on robot i to a point on body j.
///
///   w = p_j + R(psi_j) a_j - p_i - R(psi_i) a_i,   d = R(psi_i)^T w
///   range   = (r + gamma (d_x cos m + d_y sin m - r)) (1 + s_d) (1 + rho) + o,
///             r = sqrt(w_x^2 + w_y^2 + h^2),   m = mu + eps
///   bearing = (atan2(d_y, d_x) - mu) (1 + s_b) + eta
///
/// a_i, a_j are the places of sensor and point on their bodies, and h is their difference in
/// height. mu is the mounting error of the sensor, positive to the left. gamma is 0 where ranges are
/// distances, 1 where they are depths along the axis of a camera, which is eps to the left of bearing
/// 0. s_d, o and s_b are errors of scale and offset, rho and eta the lasting errors of the pair. Range
/// only, bearing only: one of the two rows.
struct RangeBearing {
  /// Order of the inputs. The filter estimates the first `estimated` of them.
  enum Input {
    x_i,
    y_i,
    psi_i,
    mu,
    s_d,
    gamma,
    eps,
    o,
    s_b,
    x_j,
    y_j,
    psi_j,
    rho,
    eta,
    a_i_x,
    a_i_y,
    a_j_x,
    a_j_y,
    h,
    inputs
  };
  static constexpr int estimated = a_i_x;

  /// @param z  (inputs) [m], [rad], [-]
  /// @return range [m] and bearing [rad]
  template <class S>
  std::array<S, 2> operator()(std::span<const S> z) const {
    const S cos_i = cos(z[psi_i]), sin_i = sin(z[psi_i]);
    const S cos_j = cos(z[psi_j]), sin_j = sin(z[psi_j]);
    const S w_x =
        z[x_j] - z[x_i] + (cos_j * z[a_j_x] - sin_j * z[a_j_y]) - (cos_i * z[a_i_x] - sin_i * z[a_i_y]);
    const S w_y =
        z[y_j] - z[y_i] + (sin_j * z[a_j_x] + cos_j * z[a_j_y]) - (sin_i * z[a_i_x] + cos_i * z[a_i_y]);
    const S d_x = cos_i * w_x + sin_i * w_y, d_y = cos_i * w_y - sin_i * w_x;
    const S distance = sqrt(w_x * w_x + w_y * w_y + z[h] * z[h]);
    const S axis = z[mu] + z[eps];
    const S depth = cos(axis) * d_x + sin(axis) * d_y;
    return {(distance + z[gamma] * (depth - distance)) * (1.0 + z[s_d]) * (1.0 + z[rho]) + z[o],
            (atan2(d_y, d_x) - z[mu]) * (1.0 + z[s_b]) + z[eta]};
  }
};

/// RangeBearing, traced once, with its derivatives over the estimated inputs.
class SightingModel {
 public:
  /// Expected range and bearing, and their derivatives (2 x estimated).
  struct Expected {
    std::array<double, 2> value{};
    Mat<2, RangeBearing::estimated> H{};
  };

  SightingModel();
  SightingModel(const SightingModel&) = delete;
  SightingModel& operator=(const SightingModel&) = delete;

  /// Not finite where sensor and point coincide. Does not allocate.
  Expected operator()(const std::array<double, RangeBearing::inputs>& z) noexcept;

 private:
  const Program& program_;
  Rows rows_;  // inputs, then outputs
  Evaluation evaluation_;
};

}  // namespace sightline
