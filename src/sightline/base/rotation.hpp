/// Rotations as 3 x 3 matrices, and angles on the circle.
#pragma once

#include <cmath>
#include <numbers>

#include "sightline/base/matrix.hpp"

namespace sightline {

/// The equivalent angle in [-pi, pi].
inline double wrap(double angle) noexcept { return std::remainder(angle, 2 * std::numbers::pi); }

/// [v]: [v] a = v x a.
inline Mat<3, 3> cross_matrix(const Vec3<double>& v) noexcept {
  return {{{{0, -v.z, v.y}, {v.z, 0, -v.x}, {-v.y, v.x, 0}}}};
}

/// Rotation by an angle [rad] about one axis.
inline Mat<3, 3> turn_x(double angle) noexcept {
  const SinCos<double> a = sincos(angle);
  return {{{{1, 0, 0}, {0, a.cos, -a.sin}, {0, a.sin, a.cos}}}};
}
inline Mat<3, 3> turn_y(double angle) noexcept {
  const SinCos<double> a = sincos(angle);
  return {{{{a.cos, 0, a.sin}, {0, 1, 0}, {-a.sin, 0, a.cos}}}};
}
inline Mat<3, 3> turn_z(double angle) noexcept {
  const SinCos<double> a = sincos(angle);
  return {{{{a.cos, -a.sin, 0}, {a.sin, a.cos, 0}, {0, 0, 1}}}};
}

/// exp([w]), the rotation by |w| [rad] about w (Rodrigues).
inline Mat<3, 3> turn(const Vec3<double>& w) noexcept {
  const double angle = norm(w);
  const SinCos<double> half = sincos(0.5 * angle);
  // sin(a) / a and (1 - cos a) / a^2 = 2 (sin(a/2) / a)^2, without a difference of nearly equal
  // numbers.
  const double s = angle > 1e-8 ? half.sin / angle : 0.5;
  const Mat<3, 3> W = cross_matrix(w);
  return identity<3>() + (2 * s * half.cos) * W + (2 * s * s) * (W * W);
}

/// First-order projection of R onto the rotations: R (3 - R^T R) / 2.
inline Mat<3, 3> orthonormal(const Mat<3, 3>& R) noexcept {
  return R * (identity<3>(1.5) - 0.5 * (transposed(R) * R));
}

/// Yaw of an attitude R_GB = turn_z(yaw) turn_y(pitch) turn_x(roll).
inline double yaw_of(const Mat<3, 3>& R) noexcept { return atan2(R(1, 0), R(0, 0)); }

/// d yaw / d theta of R exp([theta]) at theta = 0; [-] per axis of B. Not finite where the x axis is
/// vertical.
inline Vec3<double> yaw_gradient(const Mat<3, 3>& R) noexcept {
  const double x = R(0, 0), y = R(1, 0), level = x * x + y * y;
  return {0.0, (y * R(0, 2) - x * R(1, 2)) / level, (x * R(1, 1) - y * R(0, 1)) / level};
}

}  // namespace sightline
