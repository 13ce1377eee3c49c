/// A multirotor whose autopilot takes velocities and a yaw rate, and follows each with a lag.
#pragma once

#include <array>
#include <string_view>

#include "sightline/model/frames.hpp"

namespace sightline {

/// Multirotor under velocity commands in V: each velocity and the yaw rate follow their command by
///
///   v' = (u - v) / tau
///
/// What the vehicle can do is said by the limits of its inputs. The vertical velocity and the yaw rate are states:
/// height and heading go on moving for a while when a command ends.
///
///   x = [p_x, p_y, p_z, d_x, d_y, v_f, v_s, v_z, r]  position [m], heading, velocity forward, to the left and up
///                                                    [m/s], yaw rate [rad/s]
///   u = [u_f, u_s, u_z, u_psi]                       velocity forward, to the left and up [m/s], yaw rate
///                                                    anticlockwise [rad/s]
///
/// The defaults are a quadrotor of the PX4 class, with limits such as |u_f|, |u_s| <= 3, |u_z| <= 1, |u_psi| <= 0.78;
/// its lags are ours and want identifying on one's own vehicle.
struct VelocityMultirotor {
  static constexpr int nx = 9, nu = 4;
  static constexpr std::string_view name = "velocity_multirotor";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "d_x", "d_y",
                                                              "v_f", "v_s", "v_z", "r"};
  static constexpr std::array<std::string_view, nu> inputs = {"u_f", "u_s", "u_z", "u_psi"};

  double tau_f = 0.5;    ///< lag of the forward velocity [s], > 0
  double tau_s = 0.5;    ///< lag of the sideward velocity [s], > 0
  double tau_z = 0.35;   ///< lag of the vertical velocity [s], > 0
  double tau_psi = 0.2;  ///< lag of the yaw rate [s], > 0

  /// The AR.Drone 2.0 of (16): tau = -1/a in the plane, and the limits b tau = 2.863 m/s for u_f and u_s, b_z = 1 m/s
  /// and b_psi = 1.6 rad/s. (16) has no lags of climb and yaw rate; those here are ours.
  static constexpr VelocityMultirotor ar_drone() {
    constexpr double tau = 1 / 0.5092;
    return {.tau_f = tau, .tau_s = tau, .tau_z = 0.3, .tau_psi = 0.2};
  }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> d = {x[3], x[4]};
    const Vec2<S> v_G = rotate(d, {x[5], x[6]});
    const S &v_z = x[7], &r = x[8];
    return {v_G.x,
            v_G.y,
            v_z,
            -(d.y * r),
            d.x * r,
            (1 / tau_f) * (u[0] - x[5]),
            (1 / tau_s) * (u[1] - x[6]),
            (1 / tau_z) * (u[2] - v_z),
            (1 / tau_psi) * (u[3] - r)};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y, 0, 0, 0, 0};
  }

  /// Rate of the state under an acceleration a of G [m/s^2].
  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({x[3], -x[4]}, {a.x, a.y});
    return {0, 0, 0, 0, 0, a_V.x, a_V.y, a.z, 0};
  }

  static constexpr int heading_at = 3;
};

}  // namespace sightline
