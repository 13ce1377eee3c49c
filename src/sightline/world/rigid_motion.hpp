/// The group of rigid motions: composition, exponential map and adjoint.
///
/// A twist (rho, theta) has six numbers [m], [rad]. exp_of() is its motion, and log_of() the inverse:
///
///   exp(rho, theta) = (exp([theta]), V rho),   V = 1 + (1 - cos a) / a^2 [theta] + (a - sin a) / a^3 [theta]^2,
///
/// with a = |theta|. The adjoint moves a twist to the other side: X exp(xi) = exp(Ad_X xi) X.
#pragma once

#include "sightline/sensors.hpp"
#include "sightline/world.hpp"

namespace sightline {

/// Composition of the pose of b in a, and that of c in b.
inline RigidPose operator*(const RigidPose& a, const RigidPose& b) {
  return {a.p + a.R.to_G(b.p), compose(a.R, b.R)};
}

inline RigidPose inverse(const RigidPose& a) {
  const Rotation back = {a.R.to_B({1, 0, 0}), a.R.to_B({0, 1, 0}), a.R.to_B({0, 0, 1})};
  return {-1.0 * back.to_G(a.p), back};
}

inline Mat<3, 3> matrix(const Rotation& R) noexcept {
  return {{{{R.x.x, R.y.x, R.z.x}, {R.x.y, R.y.y, R.z.y}, {R.x.z, R.y.z, R.z.z}}}};
}

/// theta of R = exp([theta]), |theta| <= pi.
inline Vec3<double> rotation_vector(const Rotation& R) noexcept {
  const Quaternion q = quaternion(R);
  const Vec3<double> v = {q.x, q.y, q.z};
  const double sine = norm(v);
  return (sine > 1e-12 ? 2 * atan2(sine, q.w) / sine : 2.0) * v;
}

/// The matrix V above.
inline Mat<3, 3> translation_of_twist(const Vec3<double>& theta) noexcept {
  const double a = norm(theta);
  const Mat<3, 3> W = cross_matrix(theta);
  // The series where the fractions would cancel.
  const SinCos<double> e = sincos(a);
  const double b = a > 1e-3 ? (1 - e.cos) / (a * a) : 0.5 - a * a / 24;
  const double c = a > 1e-3 ? (a - e.sin) / (a * a * a) : 1.0 / 6 - a * a / 120;
  return identity<3>() + b * W + c * (W * W);
}

inline RigidPose exp_of(const Column<6>& xi) noexcept {
  const Vec3<double> theta = vec3(xi, 3);
  return {translation_of_twist(theta) * vec3(xi), turn_by(theta)};
}

inline Column<6> log_of(const RigidPose& X) noexcept {
  const Vec3<double> theta = rotation_vector(X.R);
  const Mat<3, 3> V = translation_of_twist(theta), Vt = transposed(V);
  // V is no symmetric matrix; V^T V is.
  const Column<3> rho = Cholesky<3>(Vt * V).solve(Vt * column(X.p));
  Column<6> xi;
  set_block(xi, 0, 0, rho);
  set_block(xi, 3, 0, column(theta));
  return xi;
}

inline Mat<6, 6> adjoint(const RigidPose& X) noexcept {
  const Mat<3, 3> R = matrix(X.R);
  Mat<6, 6> A;
  set_block(A, 0, 0, R);
  set_block(A, 3, 3, R);
  set_block(A, 0, 3, cross_matrix(X.p) * R);
  return A;
}

/// The pose at a share of the way from a to b, on the screw that joins them.
inline RigidPose between(const RigidPose& a, const RigidPose& b, double share) noexcept {
  return a * exp_of(share * log_of(inverse(a) * b));
}

}  // namespace sightline
