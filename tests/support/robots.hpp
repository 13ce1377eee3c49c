/// Robots of other sizes than the library's own, for tests and benchmarks of mixed teams.
#pragma once

#include <array>
#include <cmath>
#include <string_view>

#include "sightline/model.hpp"

namespace sightline::test {

/// A ground robot that drives where it looks.
///
///   x = [p_x, p_y, psi, v]  position [m], yaw [rad], speed [m/s]
///   u = [u_v, u_psi]        normalised commands, within [-1, 1]
struct Unicycle {
  static constexpr int nx = 4, nu = 2;
  static constexpr std::string_view name = "test_unicycle";

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    return {x[3] * cos(x[2]), x[3] * sin(x[2]), 1.5 * u[1], 1.5 * u[0] - 0.8 * x[3]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], S(0.0)}, {cos(x[2]), sin(x[2])}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, std::atan2(pose.d.y, pose.d.x), 0.0};
  }

  static constexpr int angle_at = 2;
};

/// A quadrotor with its attitude loop: it flies where its thrust leans.
///
///   x = [p, v, d, tilt, r, a_T]  position [m], velocity [m/s], heading (2), slope of the thrust
///                                (forward, left), yaw rate [rad/s], thrust per mass [m/s^2]
///   u = [u_f, u_l, u_z, u_psi]   normalised commands of slope, thrust and yaw rate, within [-1, 1]
struct Quadrotor {
  static constexpr int nx = 12, nu = 4;
  static constexpr std::string_view name = "test_quadrotor";

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    constexpr double g = 9.81, drag = 0.31, lag = 5.2, yaw_lag = 4.1;
    const Vec2<S> d = {x[6], x[7]}, lean = rotate(d, Vec2<S>{x[8], x[9]});
    return {x[3],
            x[4],
            x[5],
            x[11] * lean.x - drag * x[3],
            x[11] * lean.y - drag * x[4],
            x[11] - g - drag * x[5],
            -(d.y * x[10]),
            d.x * x[10],
            lag * (0.42 * u[0] - x[8]),
            lag * (0.42 * u[1] - x[9]),
            yaw_lag * (1.7 * u[3] - x[10]),
            lag * (g + 4.3 * u[2] - x[11])};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[6], x[7]}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, 0, 0, 0, pose.d.x, pose.d.y, 0, 0, 0, 9.81};
  }

  static constexpr int heading_at = 6;
};

}  // namespace sightline::test
