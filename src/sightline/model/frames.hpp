/// Frames and what robots show of themselves: G global, V vehicle, S sensor; (17)-(22), (40)-(48).
#pragma once

#include "sightline/math/fixed.hpp"

namespace sightline {

/// Position and heading of a robot in G; roll and pitch are neglected (hover-controlled robots).
template <class S>
struct Pose {
  Vec3<S> p;  ///< position [m]
  Vec2<S> d;  ///< heading (cos psi, sin psi), (18), (19); |d| = 1
};

/// All that a potential sees of a robot: pose and velocity in G.
template <class S>
struct Sight : Pose<S> {
  Vec3<S> v;  ///< velocity [m/s]
};

/// Numbers in a Sight, in the order p, d, v.
inline constexpr int sight_size = 8;

template <class S, class Row>
Sight<S> sight_from(const Row& r) {
  return {{{r[0], r[1], r[2]}, {r[3], r[4]}}, {r[5], r[6], r[7]}};
}

template <class S, class Row>
void write_sight(const Sight<S>& s, Row&& r) {
  r[0] = s.p.x, r[1] = s.p.y, r[2] = s.p.z;
  r[3] = s.d.x, r[4] = s.d.y;
  r[5] = s.v.x, r[6] = s.v.y, r[7] = s.v.z;
}

/// v_V in G: R(d) v, (22). The transpose turns G into V, (43).
template <class S>
Vec2<S> rotate(const Vec2<S>& d, const Vec2<S>& v_V) {
  return {d.x * v_V.x - d.y * v_V.y, d.y * v_V.x + d.x * v_V.y};
}

/// Where the sensor sits on the robot, (45); its axis in V is (cos beta, 0, -sin beta), so beta > 0 looks
/// down.
struct SensorMount {
  double pitch = 0.5;    ///< beta [rad], in (-pi/2, pi/2)
  double offset = 0.17;  ///< d_s [m], lever arm along the vehicle's x

  /// A point of G in the sensor frame S of the robot: p_S = T_SG p_G, (46), (48).
  template <class S>
  Vec3<S> operator()(const Pose<S>& robot, const Vec3<S>& point) const {
    const double c = cos(pitch), s = sin(pitch);
    const Vec3<S> r = robot.p - point;
    const S eta = offset + robot.d.x * r.x + robot.d.y * r.y;
    return {r.z * s - eta * c, robot.d.y * r.x - robot.d.x * r.y, -(r.z * c) - eta * s};
  }
};

/// Angle between the sensor axis and the point [rad], in [0, pi], (71); 0 at the sensor itself.
double view_angle(const SensorMount& mount, const Pose<double>& robot, const Vec3<double>& point);

}  // namespace sightline
