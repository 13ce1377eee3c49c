/// The library's robots: multirotors of several interfaces, ground robots, a point mass.
#pragma once

#include <array>
#include <string_view>

#include "sightline/base.hpp"
#include "sightline/model.hpp"

namespace sightline {

// Ground robots: (24) without u_z, and also without u_s.
//
// The height is a state that keeps its start value. So potentials are the same for a ground robot
// and a flying one.

/// Omnidirectional ground robot: drives forward and sideward, and turns.
///
///   x = [p_x, p_y, p_z, d_x, d_y, v_f, v_s]  position [m], heading, velocity forward and to the
///                                            left in V [m/s]
///   u = [u_f, u_s, u_psi]                    normalised commands, within [-1, 1]; u_s > 0 to the
///                                            right, as in (24)
struct OmniRover {
  static constexpr int nx = 7, nu = 3;
  static constexpr std::string_view name = "omni_rover";
  static constexpr bool rolls = true;
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "d_x",
                                                              "d_y", "v_f", "v_s"};
  static constexpr std::array<std::string_view, nu> inputs = {"u_f", "u_s", "u_psi"};

  double b_psi = 1.5;
  double a_f = -2.5;
  double b_f = 2.5;
  double a_s = -2.5;
  double b_s = 2.5;

  static constexpr auto parameters() {
    return Parameters{
        parameter("b_psi", &OmniRover::b_psi, "rad/s", any_finite, "yaw rate per command"),
        parameter("a_f", &OmniRover::a_f, "1/s", any_finite, "forward drag"),
        parameter("b_f", &OmniRover::b_f, "m/s^2", any_finite,
                  "forward acceleration per command; b_f / -a_f is the top speed"),
        parameter("a_s", &OmniRover::a_s, "1/s", any_finite, "sideward drag"),
        parameter("b_s", &OmniRover::b_s, "m/s^2", any_finite, "sideward acceleration per command")};
  }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> d = {x[3], x[4]}, v_V = {x[5], x[6]};
    const Vec2<S> v_G = rotate(d, v_V);
    const S rate = b_psi * u[2];
    return {
        v_G.x, v_G.y, S(0.0), -(d.y * rate), d.x * rate, a_f * v_V.x + b_f * u[0], a_s * v_V.y - b_s * u[1]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y, 0.0, 0.0};
  }

  /// Rate of the state under an acceleration a in G [m/s^2]; the ground cancels its vertical part.
  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({x[3], -x[4]}, {a.x, a.y});
    return {0, 0, 0, 0, 0, a_V.x, a_V.y};
  }

  static constexpr int heading_at = 3;
};

/// Unicycle ground robot: drives along its heading only.
///
///   x = [p_x, p_y, p_z, d_x, d_y, v_f]  position [m], heading, velocity forward [m/s]
///   u = [u_f, u_psi]                    normalised commands, within [-1, 1]
struct Unicycle {
  static constexpr int nx = 6, nu = 2;
  static constexpr std::string_view name = "unicycle";
  static constexpr bool rolls = true;
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f"};
  static constexpr std::array<std::string_view, nu> inputs = {"u_f", "u_psi"};

  double b_psi = 1.5, a_f = -2.5, b_f = 2.5;

  static constexpr auto parameters() {
    return Parameters{parameter("b_psi", &Unicycle::b_psi, "rad/s", any_finite, "yaw rate per command"),
                      parameter("a_f", &Unicycle::a_f, "1/s", any_finite, "forward drag"),
                      parameter("b_f", &Unicycle::b_f, "m/s^2", any_finite,
                                "forward acceleration per command; b_f / -a_f is the top speed")};
  }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> d = {x[3], x[4]};
    const S rate = b_psi * u[1];
    return {x[5] * d.x, x[5] * d.y, S(0.0), -(d.y * rate), d.x * rate, a_f * x[5] + b_f * u[0]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y, 0.0};
  }

  /// Rate of the state under an acceleration a in G [m/s^2]; the wheels cancel its part across the
  /// heading.
  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    return {0, 0, 0, 0, 0, x[3] * a.x + x[4] * a.y};
  }

  static constexpr int heading_at = 3;
};

// Multirotor models for identification from flights: (24), with the effects that (24) neglects.

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
    return detail::multirotor_parameters<M>() +
           Parameters{parameter("tau", &M::tau, "s", lag_or_none,
                                "lag of the tilt; 0 with the other two: no state lags"),
                      parameter("tau_z", &M::tau_z, "s", lag_or_none, "lag of the climb"),
                      parameter("tau_psi", &M::tau_psi, "s", lag_or_none, "lag of the yaw rate")};
  }

  /// The vehicles of vehicle.hpp, as identified by `sightline identify` for tilt_max = 0.2
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

// The simplest robot: a point mass with commanded acceleration.

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
    return Parameters{
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

// Multirotors whose autopilot receives velocities and a yaw rate, and follows them with lags.

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
    return Parameters{
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
