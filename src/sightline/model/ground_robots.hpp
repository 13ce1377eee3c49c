/// Ground robots: (24) without u_z, and also without u_s.
///
/// The height is a state that keeps its start value. So potentials are the same for a ground robot
/// and a flying one.
#pragma once

#include <array>
#include <string_view>

#include "sightline/base/parameter.hpp"
#include "sightline/model/frames.hpp"

namespace sightline {

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
    return std::tuple{
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
    return std::tuple{parameter("b_psi", &Unicycle::b_psi, "rad/s", any_finite, "yaw rate per command"),
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

}  // namespace sightline
