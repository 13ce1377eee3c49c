/// One rigid body: position and attitude in G, and its motion under forces and torques.
#pragma once

#include "sightline/model/frames.hpp"

namespace sightline {

inline Vec3<double> cross(const Vec3<double>& a, const Vec3<double>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Attitude: rotates coordinates from the body frame B to G. |q| = 1.
struct Quaternion {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;

  bool operator==(const Quaternion&) const = default;
};
/// Placeholder for an unknown attitude.
inline constexpr Quaternion no_attitude = {0.0, 0.0, 0.0, 0.0};

/// Attitude as a matrix, by its columns: the axes of B in G.
struct Rotation {
  Vec3<double> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  Vec3<double> to_G(const Vec3<double>& a_B) const { return a_B.x * x + a_B.y * y + a_B.z * z; }
  Vec3<double> to_B(const Vec3<double>& a_G) const { return {dot(x, a_G), dot(y, a_G), dot(z, a_G)}; }
};

inline Rotation rotation(const Quaternion& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (xz - wy)},
          {2 * (xy - wz), 1 - 2 * (xx + zz), 2 * (yz + wx)},
          {2 * (xz + wy), 2 * (yz - wx), 1 - 2 * (xx + yy)}};
}

/// Composition: R_GB and R_BC to R_GC.
inline Rotation compose(const Rotation& R_GB, const Rotation& R_BC) {
  return {R_GB.to_G(R_BC.x), R_GB.to_G(R_BC.y), R_GB.to_G(R_BC.z)};
}
/// R_AB, the attitude of B relative to A, from the attitudes of both in G.
inline Rotation between(const Rotation& R_GA, const Rotation& R_GB) {
  return {R_GA.to_B(R_GB.x), R_GA.to_B(R_GB.y), R_GA.to_B(R_GB.z)};
}
/// Rotation by |w| [rad] about w.
inline Rotation turn_by(const Vec3<double>& w) {
  const double angle = norm(w);
  const SinCos<double> half = sincos(0.5 * angle);
  const double s = angle > 0 ? half.sin / angle : 0.5;
  return rotation({half.cos, s * w.x, s * w.y, s * w.z});
}
/// Quaternion of a rotation; of the two equivalent ones, the one with w >= 0.
inline Quaternion quaternion(const Rotation& R) {
  const double xx = R.x.x, yy = R.y.y, zz = R.z.z;
  Quaternion q;
  if (xx + yy + zz >= 0) {
    q = {1 + xx + yy + zz, R.y.z - R.z.y, R.z.x - R.x.z, R.x.y - R.y.x};
  } else if (xx >= yy && xx >= zz) {
    q = {R.y.z - R.z.y, 1 + xx - yy - zz, R.x.y + R.y.x, R.x.z + R.z.x};
  } else if (yy >= zz) {
    q = {R.z.x - R.x.z, R.x.y + R.y.x, 1 + yy - xx - zz, R.y.z + R.z.y};
  } else {
    q = {R.x.y - R.y.x, R.x.z + R.z.x, R.y.z + R.z.y, 1 + zz - xx - yy};
  }
  const double scale = (q.w < 0 ? -1 : 1) / sqrt(square(q.w) + square(q.x) + square(q.y) + square(q.z));
  return {scale * q.w, scale * q.x, scale * q.y, scale * q.z};
}

/// Horizontal unit direction of the body's x axis; (1, 0) if x is exactly vertical.
inline Vec2<double> heading(const Rotation& R) {
  const double level = norm(R.x.x, R.x.y);
  if (!(level > 0)) return {1, 0};
  return {R.x.x / level, R.x.y / level};
}
/// Tangent of the tilt of the body's z axis, forward and to the left of the heading: the `lean` of
/// a Sight. Bounded for every attitude.
inline Vec2<double> lean(const Rotation& R) {
  constexpr double least_up = 0.1;
  const Vec2<double> d = heading(R);
  const double up = R.z.z > least_up ? R.z.z : least_up;
  return rotate<double>({d.x, -d.y}, {R.z.x / up, R.z.y / up});
}
/// Rate of the heading [rad/s] at the angular velocity w, in B. From R' = R [w], whose first column
/// is w_z y - w_y z.
inline double heading_rate(const Rotation& R, const Vec3<double>& w) {
  const double level = square(R.x.x) + square(R.x.y);
  if (!(level > 0)) return 0.0;
  const Vec3<double> rate = w.z * R.y - w.y * R.z;
  return (R.x.x * rate.y - R.x.y * rate.x) / level;
}
/// Attitude with this heading d and tilt tangents `lean`: yaw, pitch atan(lean.x), roll.
inline Quaternion leaning(const Vec2<double>& d, const Vec2<double>& lean) {
  const double yaw = 0.5 * atan2(d.y, d.x), pitch = 0.5 * atan2(lean.x, 1.0),
               roll = -0.5 * atan2(lean.y, sqrt(1.0 + square(lean.x)));
  const double cz = cos(yaw), sz = sin(yaw), cy = cos(pitch), sy = sin(pitch), cx = cos(roll), sx = sin(roll);
  return {cx * cy * cz + sx * sy * sz, sx * cy * cz - cx * sy * sz, cx * sy * cz + sx * cy * sz,
          cx * cy * sz - sx * sy * cz};
}
/// Attitude without tilt, with this heading.
inline Quaternion upright(const Vec2<double>& d) {
  const double half = 0.5 * atan2(d.y, d.x);
  return {cos(half), 0, 0, sin(half)};
}

/// Newton-Euler equations,
///
///   m v' = F_G,   I w' + w x I w = M_B,   p' = v,   q' = q (0, w) / 2,
///
/// integrated by the semi-implicit Euler step: first the velocities at the old state, then position
/// and attitude with the new velocities. The attitude step is an exact rotation. MuJoCo's
/// integrator "Euler" uses the same order, so both give equal flights. First order: energy and
/// angular momentum of a freely rotating body drift in proportion to the step.
struct RigidBody {
  double mass = 1.0;                 ///< [kg], > 0
  Vec3<double> inertia = {1, 1, 1};  ///< about the axes of B, which are principal [kg m^2], > 0
  Vec3<double> p{}, v{};             ///< of the centre of mass, in G [m], [m/s]
  Quaternion q{};                    ///< B to G
  Vec3<double> w{};                  ///< angular velocity, in B [rad/s]

  /// Advances by h [s].
  /// @param force   on the centre of mass, including weight, in G [N]
  /// @param torque  about the centre of mass, in B [N m]
  void step(const Vec3<double>& force, const Vec3<double>& torque, double h) noexcept {
    v = v + (h / mass) * force;
    const Vec3<double> spin = {inertia.x * w.x, inertia.y * w.y, inertia.z * w.z};
    const Vec3<double> moment = torque - cross(w, spin);
    w = w + h * Vec3<double>{moment.x / inertia.x, moment.y / inertia.y, moment.z / inertia.z};
    p = p + h * v;
    turn(h);
  }

  Vec3<double> momentum() const { return mass * v; }  ///< in G [kg m/s]
  Vec3<double> angular_momentum() const {             ///< about the centre of mass, in G [N m s]
    return rotation(q).to_G({inertia.x * w.x, inertia.y * w.y, inertia.z * w.z});
  }
  /// Kinetic energy of translation and rotation [J].
  double energy() const {
    return 0.5 *
           (mass * dot(v, v) + inertia.x * square(w.x) + inertia.y * square(w.y) + inertia.z * square(w.z));
  }

 private:
  void turn(double h) noexcept {
    const double rate = norm(w);
    const SinCos<double> half = sincos(0.5 * h * rate);
    const double s = rate > 0 ? half.sin / rate : 0.5 * h;
    const Quaternion d = {half.cos, s * w.x, s * w.y, s * w.z};
    const Quaternion n = {
        q.w * d.w - q.x * d.x - q.y * d.y - q.z * d.z, q.w * d.x + q.x * d.w + q.y * d.z - q.z * d.y,
        q.w * d.y - q.x * d.z + q.y * d.w + q.z * d.x, q.w * d.z + q.x * d.y - q.y * d.x + q.z * d.w};
    const double size = 1 / sqrt(n.w * n.w + n.x * n.x + n.y * n.y + n.z * n.z);
    q = {size * n.w, size * n.x, size * n.y, size * n.z};
  }
};

}  // namespace sightline
