/// The simplest robot: a point mass with commanded acceleration.
#pragma once

#include <array>
#include <string_view>

#include "sightline/base/parameter.hpp"
#include "sightline/model/frames.hpp"

namespace sightline {

/// A point mass in three dimensions, linear: v' = u - drag v. It has no heading: V is parallel to
/// G.
///
///   x = [p_x, p_y, p_z, v_x, v_y, v_z]  position [m] and velocity [m/s] in G
///   u = [u_x, u_y, u_z]                 acceleration in G [m/s^2]
struct PointMass {
  static constexpr int nx = 6, nu = 3;
  static constexpr std::string_view name = "point_mass";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "v_x", "v_y", "v_z"};
  static constexpr std::array<std::string_view, nu> inputs = {"u_x", "u_y", "u_z"};

  double drag = 0.0;

  static constexpr auto parameters() {
    return std::tuple{
        parameter("drag", &PointMass::drag, "1/s", from_zero, "how fast it slows down by itself")};
  }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    return {x[3], x[4], x[5], u[0] - drag * x[3], u[1] - drag * x[4], u[2] - drag * x[5]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {S(1.0), S(0.0)}};
  }

  /// Tilt: commanded horizontal acceleration over gravity. Aerodynamic drag is not part of the
  /// thrust.
  template <class S>
  Vec2<S> lean(const std::array<S, nx>&, const std::array<S, nu>& u) const {
    return {(1 / gravity) * u[0], (1 / gravity) * u[1]};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, 0, 0, 0};
  }

  /// Rate of the state under an acceleration a in G [m/s^2].
  std::array<double, nx> push(const std::array<double, nx>&, const Vec3<double>& a) const {
    return {0, 0, 0, a.x, a.y, a.z};
  }
};

}  // namespace sightline
