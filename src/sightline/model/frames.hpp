/// Frames, poses and sensor mounts: G global, V vehicle, B body, S sensor; (17)-(22), (40)-(48).
#pragma once

#include <array>
#include <concepts>
#include <string_view>

#include "sightline/base/fixed.hpp"

namespace sightline {

inline constexpr double gravity = 9.81;  ///< g [m/s^2]

/// Position and heading of a robot in G; roll and pitch are neglected (hover-controlled robots).
template <class S>
struct Pose {
  Vec3<S> p;  ///< position [m]
  Vec2<S> d;  ///< heading (cos psi, sin psi), (18), (19); |d| = 1
};

/// Arguments of a potential for one robot: pose and velocity in G, tilt, uncertainty of its view,
/// and the third body of the coupling.
///
/// The tilt xi is the tangent of the thrust's angle to the vertical: horizontal over vertical
/// specific thrust, by its components in V. The thrust points along (xi_f, xi_s, 1). An upright
/// robot has (0, 0).
template <class S>
struct Sight : Pose<S> {
  Vec3<S> v;        ///< velocity [m/s]
  Vec2<S> lean{};   ///< tilt xi = (xi_f, xi_s), forward and to the left [-]
  S uncertainty{};  ///< lateral standard deviation of the observed body's relative position [m]; 0: exact
  Vec3<S> third{};  ///< in the first body of a coupling: position in G of the third one [m]
};

/// Numbers of a Sight that follow from state and input, in the order p, d, v, lean.
inline constexpr int sight_size = 10;

template <class S, class Row>
Sight<S> sight_from(const Row& r) {
  return {{{r[0], r[1], r[2]}, {r[3], r[4]}}, {r[5], r[6], r[7]}, {r[8], r[9]}};
}

template <class S, class Row>
void write_sight(const Sight<S>& s, Row&& r) {
  r[0] = s.p.x, r[1] = s.p.y, r[2] = s.p.z;
  r[3] = s.d.x, r[4] = s.d.y;
  r[5] = s.v.x, r[6] = s.v.y, r[7] = s.v.z;
  r[8] = s.lean.x, r[9] = s.lean.y;
}

/// Rotates v_V from V to G: R(d) v, (22). The transpose rotates from G to V, (43).
template <class S>
Vec2<S> rotate(const Vec2<S>& d, const Vec2<S>& v_V) {
  return {d.x * v_V.x - d.y * v_V.y, d.y * v_V.x + d.x * v_V.y};
}

/// Frame to which a sensor is fixed.
enum class MountFrame {
  level,  ///< V, as in the paper: a gimbal holds the sensor level
  body,   ///< B, which tilts with the thrust
};
inline constexpr std::array<std::string_view, 2> mount_frames = {"level", "body"};

/// Mount of a sensor on the robot, (45). The sensor axis in V, or in B, is (cos beta, 0, -sin
/// beta), so beta > 0 points down.
///
/// B is V pitched and rolled: z along the thrust, x in the vertical plane of the heading. Its axes
/// in V, before normalisation, are, with xi the tilt (docs/equations.md, 1),
///
///   x_B ~ (1, 0, -xi_f),   y_B ~ (-xi_f xi_s, 1 + xi_f^2, -xi_s),   z_B ~ (xi_f, xi_s, 1)
struct SensorMount {
  double pitch = 0.5;                    ///< beta [rad], in [-pi/2, pi/2]
  double offset = 0.17;                  ///< d_s [m], lever arm along x of V or B
  MountFrame frame = MountFrame::level;  ///< frame of pitch and offset
  double sigmas = 0.0;  ///< standard deviations of Sight::uncertainty that the view must tolerate, >= 0

  bool operator==(const SensorMount&) const = default;

  /// Transforms a point of G into the sensor frame S of an upright robot: p_S = T_SG p_G, (46),
  /// (48).
  template <class S>
  Vec3<S> operator()(const Pose<S>& robot, const Vec3<S>& point) const {
    const double c = cos(pitch), s = sin(pitch);
    const Vec3<S> r = robot.p - point;
    const S eta = offset + robot.d.x * r.x + robot.d.y * r.y;
    return {r.z * s - eta * c, robot.d.y * r.x - robot.d.x * r.y, -(r.z * c) - eta * s};
  }

  /// The same for a tilted robot: p_S = T_SB T_BV T_VG p_G if the sensor is fixed to the body. At
  /// zero tilt both give the same bits.
  template <class S>
  Vec3<S> operator()(const Sight<S>& robot, const Vec3<S>& point) const {
    if (frame == MountFrame::level)
      return farthest(robot.uncertainty, (*this)(static_cast<const Pose<S>&>(robot), point));
    const double c = cos(pitch), s = sin(pitch);
    const Vec2<S>& xi = robot.lean;
    const Vec3<S> r = robot.p - point;
    // From the point to the robot, in V; ahead with the lever arm, y to the right.
    const S arm = offset + robot.d.x * r.x + robot.d.y * r.y, ahead = robot.d.x * r.x + robot.d.y * r.y;
    const S right = robot.d.y * r.x - robot.d.x * r.y;
    const S of_x = 1.0 + square(xi.x), of_z = of_x + square(xi.y);
    const S per_x = 1.0 / sqrt(of_x), per_z = 1.0 / sqrt(of_z);
    // In B; the tilt does not rotate the lever arm itself.
    const S eta = offset * (1.0 - per_x) + per_x * (arm - xi.x * r.z);
    const S y = (of_x * right + xi.y * (xi.x * ahead + r.z)) * (per_x * per_z);
    const S z = (r.z + xi.x * ahead - xi.y * right) * per_z;
    return farthest(robot.uncertainty, Vec3<S>{z * s - eta * c, y, -(z * c) - eta * s});
  }

  /// Of the points displaced laterally by `sigmas` standard deviations from p_S, the one farthest
  /// off the axis. If it is in view, all are. Within about that radius rho of the axis the
  /// direction is undefined, so the displacement is smaller: (y, z) is scaled by 1 + rho / sqrt(y^2
  /// + z^2 + rho^2), docs/equations.md, 1.
  template <class S>
  Vec3<S> farthest(const S& uncertainty, const Vec3<S>& p_S) const {
    if (sigmas == 0.0) return p_S;
    constexpr double axis = 1e-12;  // keeps the root positive for rho = 0 on the axis [m^2]
    const S rho = sigmas * uncertainty;
    const S grown = 1.0 + rho / sqrt(square(p_S.y) + square(p_S.z) + square(rho) + axis);
    return {p_S.x, grown * p_S.y, grown * p_S.z};
  }
};

/// Angle between the sensor axis and a point of S [rad], in [0, pi], (71); 0 at the sensor itself.
double off_axis(const Vec3<double>& p_S);

/// Angle between the sensor axis and a point of G [rad]. The overload for a Pose assumes an upright
/// robot; the one for a Sight includes its tilt.
inline double view_angle(const SensorMount& mount, const Pose<double>& robot, const Vec3<double>& point) {
  return off_axis(mount(robot, point));
}
template <std::same_as<Sight<double>> Seen>
double view_angle(const SensorMount& mount, const Seen& robot, const Vec3<double>& point) {
  return off_axis(mount(robot, point));
}

}  // namespace sightline
