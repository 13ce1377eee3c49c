/// Multirotor models for identification from flights: (24), with the effects that (24) neglects.
#pragma once

#include <array>
#include <string_view>

#include "sightline/base/parameter.hpp"
#include "sightline/base/throw_invalid.hpp"
#include "sightline/model/robots.hpp"

namespace sightline {

/// Whether tilt, climb and yaw rate follow their commands with lags, as additional states.
enum class HoverLags { none, all };

/// Extension of (24): the velocity keeps its direction in G while the vehicle yaws, with the rate r
/// of its heading,
///
///   v_f' = a_f v_f + b_f u_f + r v_s,   v_s' = a_s v_s - b_s u_s - r v_f
///
/// With lags, the acceleration of the tilt (g tan), the climb and the yaw rate are states that
/// follow their commands,
///
///   tau a_f' = b_f u_f - a_f,     tau a_s' = -b_s u_s - a_s,
///   tau_z v_z' = b_z u_z - v_z,   tau_psi r' = b_psi u_psi - r
///
/// Then (1 + v_z' / g) a_f and (1 + v_z' / g) a_s replace b_f u_f and -b_s u_s, because a larger
/// thrust also has a larger horizontal part. The states a_f and a_s are accelerations; the
/// parameters of these names are drag, as in (24).
///
///   x = [p_x, p_y, p_z, d_x, d_y, v_f, v_s, a_f, a_s, v_z, r]
///       position [m], heading, velocity forward and to the left in V [m/s]; with lags acceleration
///       of the tilt forward and to the left [m/s^2], climb [m/s], yaw rate [rad/s]
///   u = [u_f, u_s, u_z, u_psi]
///       normalised commands as in (24), within [-1, 1]
///
/// The defaults are x500().
template <HoverLags lags>
struct LaggedHoverMultirotor {
  static constexpr bool lagging = lags == HoverLags::all;
  static constexpr int nx = lagging ? 11 : 7, nu = 4;
  static constexpr double g = gravity;
  static constexpr std::string_view name = "hover_multirotor";
  static constexpr std::array<std::string_view, nx> states = [] {
    std::array<std::string_view, nx> all = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f", "v_s"};
    if constexpr (lagging) all[7] = "a_f", all[8] = "a_s", all[9] = "v_z", all[10] = "r";
    return all;
  }();
  static constexpr std::array<std::string_view, nu> inputs = Multirotor::inputs;

  double b_z = 1.08;
  double b_psi = 1.6;
  double a_f = -0.123;
  double b_f = 2.0;
  double a_s = -0.123;
  double b_s = 2.0;
  double tau = lag(0.121);
  double tau_z = lag(0.231);
  double tau_psi = lag(0.16);

  static constexpr auto parameters() {
    using M = LaggedHoverMultirotor;
    constexpr Bounds lag_or_none = {1e-3, 1e3, "0 or 0.001 to 1000", true};
    return std::tuple_cat(
        detail::multirotor_parameters<M>(),
        std::tuple{parameter("tau", &M::tau, "s", lag_or_none,
                             "lag of the tilt; 0 with the other two: no state lags"),
                   parameter("tau_z", &M::tau_z, "s", lag_or_none, "lag of the climb"),
                   parameter("tau_psi", &M::tau_psi, "s", lag_or_none, "lag of the yaw rate")});
  }

  /// The vehicles of world/vehicle.hpp, as identified by `sightline identify` for tilt_max = 0.2
  /// rad. The models without lags follow a delay of 0.16 s, 0.114 s and 0.139 s; those with lags
  /// 0.036 s, 0.028 s and 0.025 s. ar_drone() has the numbers of (16).
  static constexpr LaggedHoverMultirotor x500() { return {}; }
  static constexpr LaggedHoverMultirotor crazyflie() {
    return {.b_z = 1.0,
            .b_psi = 1.585,
            .a_f = -0.484,
            .b_f = 2.03,
            .a_s = -0.484,
            .b_s = 2.03,
            .tau = lag(0.07),
            .tau_z = lag(0.229),
            .tau_psi = lag(0.136)};
  }
  static constexpr LaggedHoverMultirotor ar_drone() {
    return {.b_z = 1.0,
            .b_psi = 1.6,
            .a_f = -0.5092,
            .b_f = 1.458,
            .a_s = -0.5092,
            .b_s = 1.458,
            .tau = lag(0.102),
            .tau_z = lag(0.232),
            .tau_psi = lag(0.14)};
  }
  static constexpr auto presets() {
    return std::array{Preset<LaggedHoverMultirotor>{"x500", x500()},
                      Preset<LaggedHoverMultirotor>{"crazyflie", crazyflie()},
                      Preset<LaggedHoverMultirotor>{"ar_drone", ar_drone()}};
  }
  /// Calls `make` with the model that a scenario uses: without the lag states if all lags are 0.
  template <class Make>
  auto reduced(Make&& make) const {
    if (tau == 0 && tau_z == 0 && tau_psi == 0)
      return make(LaggedHoverMultirotor<HoverLags::none>::of(*this));
    return make(LaggedHoverMultirotor<HoverLags::all>::of(*this));
  }
  /// The same vehicle with the other choice of states.
  template <HoverLags others>
  static constexpr LaggedHoverMultirotor of(const LaggedHoverMultirotor<others>& m) {
    return {m.b_z, m.b_psi, m.a_f, m.b_f, m.a_s, m.b_s, m.tau, m.tau_z, m.tau_psi};
  }

  /// @throws std::invalid_argument if only some lags are 0, or if the lags do not match the states
  void check() const {
    const bool all = tau > 0 && tau_z > 0 && tau_psi > 0, none = tau == 0 && tau_z == 0 && tau_psi == 0;
    if (lagging ? !all : !none)
      throw_invalid("{}.tau, tau_z, tau_psi = {}, {}, {} s, expected {}", name, tau, tau_z, tau_psi,
                    lagging ? "all three above 0 s, or none" : "0 s: its states do not lag");
  }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> d = {x[3], x[4]}, v_V = {x[5], x[6]};
    const Vec2<S> v_G = rotate(d, v_V);
    Vec2<S> push = {b_f * u[0], -(b_s * u[1])};
    S climb = b_z * u[2], rate = b_psi * u[3];
    std::array<S, nx> change;
    if constexpr (lagging) {
      change[7] = (1 / tau) * (push.x - x[7]);
      change[8] = (1 / tau) * (push.y - x[8]);
      change[9] = (1 / tau_z) * (climb - x[9]);
      change[10] = (1 / tau_psi) * (rate - x[10]);
      const S lift = 1.0 + (1 / g) * change[9];
      push = {lift * x[7], lift * x[8]}, climb = x[9], rate = x[10];
    }
    change[0] = v_G.x;
    change[1] = v_G.y;
    change[2] = climb;
    change[3] = -(d.y * rate);
    change[4] = d.x * rate;
    change[5] = a_f * v_V.x + push.x + rate * v_V.y;
    change[6] = a_s * v_V.y + push.y - rate * v_V.x;
    return change;
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }

  /// Tilt: the actual one if it is a state, else the commanded one. Aerodynamic drag is not part of
  /// the thrust.
  template <class S>
  Vec2<S> lean([[maybe_unused]] const std::array<S, nx>& x,
               [[maybe_unused]] const std::array<S, nu>& u) const {
    if constexpr (lagging) return {(1 / g) * x[7], (1 / g) * x[8]};
    return {(b_f / g) * u[0], (-b_s / g) * u[1]};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y};
  }

  /// Rate of the state under an acceleration a in G [m/s^2]; a directly commanded climb is not
  /// affected.
  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({x[3], -x[4]}, {a.x, a.y});
    std::array<double, nx> change = {0, 0, 0, 0, 0, a_V.x, a_V.y};
    if constexpr (lagging) change[9] = a.z;
    return change;
  }

  static constexpr int heading_at = 3;

 private:
  static constexpr double lag(double tau_of_state) { return lagging ? tau_of_state : 0.0; }
};

using HoverMultirotor = LaggedHoverMultirotor<HoverLags::none>;
using LaggingHoverMultirotor = LaggedHoverMultirotor<HoverLags::all>;

}  // namespace sightline
