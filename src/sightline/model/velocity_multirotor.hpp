/// Multirotors whose autopilot receives velocities and a yaw rate, and follows them with lags.
#pragma once

#include <array>
#include <string_view>

#include "sightline/base/parameter.hpp"
#include "sightline/model/frames.hpp"

namespace sightline {

/// Lagging quantities that are states, in addition to the velocities in the plane of V.
enum class Lags { plane, climb, yaw, all };

/// Frame in which the horizontal velocity is constant while the vehicle yaws.
enum class VelocityFrame {
  heading,  ///< in V: the velocity rotates with the heading
  level,    ///< in G, as for a body with mass
};
inline constexpr std::array<std::string_view, 2> velocity_frames = {"heading", "level"};

/// Multirotor under velocity commands in V. A velocity follows its command by
///
///   v' = (u - v) / tau,   or without delay if it is not a state
///
/// With a lag, height and heading continue to change for a while after a command ends. The frame
/// `level` adds the Coriolis term of V, with r the rate of the heading:
///
///   v_f' = (u_f - v_f) / tau_f + r v_s,   v_s' = (u_s - v_s) / tau_s - r v_f
///
///   x = [p_x, p_y, p_z, d_x, d_y, v_f, v_s, v_z, r]  position [m], heading, velocity forward, left
///                                                    and up [m/s], yaw rate [rad/s]; v_z and r
///                                                    only if they lag
///   u = [u_f, u_s, u_z, u_psi]                       velocity forward, left and up [m/s], yaw rate
///                                                    anticlockwise [rad/s]
///
/// The defaults are px4().
template <Lags lags>
struct LaggedMultirotor {
  static constexpr bool climb_lags = lags == Lags::climb || lags == Lags::all;
  static constexpr bool yaw_lags = lags == Lags::yaw || lags == Lags::all;
  static constexpr int nx = 7 + (climb_lags ? 1 : 0) + (yaw_lags ? 1 : 0), nu = 4;
  static constexpr std::size_t climb_at = climb_lags ? 7 : 0, rate_at = nx - 1;  // if they are states
  static constexpr std::string_view name = "velocity_multirotor";
  static constexpr std::array<std::string_view, nx> states = [] {
    std::array<std::string_view, nx> all = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f", "v_s"};
    if (climb_lags) all[climb_at] = "v_z";
    if (yaw_lags) all[rate_at] = "r";
    return all;
  }();
  static constexpr std::array<std::string_view, nu> inputs = {"u_f", "u_s", "u_z", "u_psi"};

  double tau_f = 0.5;
  double tau_s = 0.5;
  double tau_z = 0.35;
  double tau_psi = 0.2;
  double v_max = 3.0;
  double climb_max = 1.0;
  double yaw_max = 0.78;
  VelocityFrame frame = VelocityFrame::heading;

  static constexpr auto parameters() {
    using M = LaggedMultirotor;
    constexpr Bounds lag = {1e-3, 1e3, "0.001 to 1000"},
                     lag_or_none = {1e-3, 1e3, "0 or 0.001 to 1000", true};
    return std::tuple{
        parameter("tau_f", &M::tau_f, "s", lag, "lag of the forward velocity"),
        parameter("tau_s", &M::tau_s, "s", lag, "lag of the sideward velocity"),
        parameter("tau_z", &M::tau_z, "s", lag_or_none, "lag of the vertical velocity; 0: v_z is no state"),
        parameter("tau_psi", &M::tau_psi, "s", lag_or_none, "lag of the yaw rate; 0: r is no state"),
        parameter("v_max", &M::v_max, "m/s", above_zero, "limit of u_f and u_s"),
        parameter("climb_max", &M::climb_max, "m/s", above_zero, "limit of u_z"),
        parameter("yaw_max", &M::yaw_max, "rad/s", above_zero, "limit of u_psi"),
        parameter("frame", &M::frame, velocity_frames,
                  "where its velocity stays while it yaws: with the heading, or level, in G")};
  }

  /// A quadrotor of the PX4 class with moderate limits. Its lags are our estimates; identify those
  /// of your own vehicle.
  static constexpr LaggedMultirotor px4() { return {}; }
  /// The AR.Drone 2.0 of (16): tau = -1/a in the plane, limits b/-a = 2.863 m/s, b_z = 1 m/s and
  /// b_psi = 1.6 rad/s. (16) has no lags of climb and yaw rate; those here are our estimates.
  static constexpr LaggedMultirotor ar_drone() {
    constexpr double tau = 1 / 0.5092;
    return {.tau_f = tau,
            .tau_s = tau,
            .tau_z = 0.3,
            .tau_psi = 0.2,
            .v_max = 1.458 * tau,
            .climb_max = 1.0,
            .yaw_max = 1.6};
  }
  static constexpr auto presets() {
    return std::array{Preset<LaggedMultirotor>{"px4", px4()},
                      Preset<LaggedMultirotor>{"ar_drone", ar_drone()}};
  }
  /// Calls `make` with the model that a scenario uses: without the states whose lag is 0.
  template <class Make>
  auto reduced(Make&& make) const {
    if (tau_z == 0 && tau_psi == 0) return make(LaggedMultirotor<Lags::plane>::of(*this));
    if (tau_z == 0) return make(LaggedMultirotor<Lags::yaw>::of(*this));
    if (tau_psi == 0) return make(LaggedMultirotor<Lags::climb>::of(*this));
    return make(*this);
  }
  /// The same vehicle with another choice of lag states.
  template <Lags others>
  static constexpr LaggedMultirotor of(const LaggedMultirotor<others>& m) {
    return {m.tau_f, m.tau_s, m.tau_z, m.tau_psi, m.v_max, m.climb_max, m.yaw_max, m.frame};
  }

  std::array<double, nu> u_max() const { return {v_max, v_max, climb_max, yaw_max}; }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    // In the form of (24), including gains of 1, so that a robot without further lags uses the
    // kernel of (24).
    const double a_f = -1 / tau_f, b_f = 1 / tau_f, a_s = -1 / tau_s, b_s = -1 / tau_s, b_z = 1.0,
                 b_psi = 1.0;
    const Vec2<S> d = {x[3], x[4]}, v_V = {x[5], x[6]};
    const Vec2<S> v_G = rotate(d, v_V);
    const S rate = yaw_lags ? x[rate_at] : b_psi * u[3];
    std::array<S, nx> change = {v_G.x,
                                v_G.y,
                                climb_lags ? x[climb_at] : b_z * u[2],
                                -(d.y * rate),
                                d.x * rate,
                                a_f * v_V.x + b_f * u[0],
                                a_s * v_V.y - b_s * u[1]};
    if (frame == VelocityFrame::level) {
      change[5] = change[5] + rate * v_V.y;
      change[6] = change[6] - rate * v_V.x;
    }
    if constexpr (climb_lags) change[climb_at] = (1 / tau_z) * (u[2] - x[climb_at]);
    if constexpr (yaw_lags) change[rate_at] = (1 / tau_psi) * (u[3] - x[rate_at]);
    return change;
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }

  /// Tilt from the acceleration in G, by its components in V: (u - v) / tau, plus the rotation of
  /// the velocity with the heading for frame `heading`. The model has no drag and neglects the
  /// climb: 1 m/s^2 of climb changes the tilt by a tenth.
  template <class S>
  Vec2<S> lean(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    if (frame == VelocityFrame::level) {
      return {(1 / gravity) * ((1 / tau_f) * (u[0] - x[5])), (1 / gravity) * ((1 / tau_s) * (u[1] - x[6]))};
    }
    const S rate = yaw_lags ? x[rate_at] : u[3];
    return {(1 / gravity) * ((1 / tau_f) * (u[0] - x[5]) - rate * x[6]),
            (1 / gravity) * ((1 / tau_s) * (u[1] - x[6]) + rate * x[5])};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y};
  }

  /// Rate of the state under an acceleration a in G [m/s^2]. It does not affect a directly
  /// commanded vertical velocity.
  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({x[3], -x[4]}, {a.x, a.y});
    std::array<double, nx> change = {0, 0, 0, 0, 0, a_V.x, a_V.y};
    if constexpr (climb_lags) change[climb_at] = a.z;
    return change;
  }

  static constexpr int heading_at = 3;
};

using VelocityMultirotor = LaggedMultirotor<Lags::all>;

}  // namespace sightline
