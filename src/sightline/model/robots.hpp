/// Robot models. Each is one struct: x' = f(x, u), pose(x), and the state at rest in a given pose.
///
/// A user-defined robot is a struct of the same form. Everything else (velocity in G, derivatives)
/// follows from it.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "sightline/base/parameter.hpp"
#include "sightline/model/frames.hpp"

namespace sightline {

namespace detail {

/// Common parameters of (24) and (15).
template <class M>
constexpr auto multirotor_parameters() {
  return std::tuple{parameter("b_z", &M::b_z, "m/s", any_finite, "climb per command"),
                    parameter("b_psi", &M::b_psi, "rad/s", any_finite, "yaw rate per command"),
                    parameter("a_f", &M::a_f, "1/s", any_finite, "forward drag"),
                    parameter("b_f", &M::b_f, "m/s^2", any_finite, "forward acceleration per command"),
                    parameter("a_s", &M::a_s, "1/s", any_finite, "sideward drag"),
                    parameter("b_s", &M::b_s, "m/s^2", any_finite, "sideward acceleration per command")};
}

}  // namespace detail

/// Hover-controlled multirotor with the heading as a direction vector, (24). The defaults are the
/// AR.Drone 2.0, (16).
///
///   x = [p_x, p_y, p_z, d_x, d_y, v_f, v_s]  position [m], heading, velocity forward and to the
///                                            left in V [m/s]
///   u = [u_f, u_s, u_z, u_psi]               normalised commands, within [-1, 1]
struct Multirotor {
  static constexpr int nx = 7, nu = 4;
  static constexpr std::string_view name = "multirotor";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "d_x",
                                                              "d_y", "v_f", "v_s"};
  static constexpr std::array<std::string_view, nu> inputs = {"u_f", "u_s", "u_z", "u_psi"};

  double b_z = 1.0;
  double b_psi = 1.6;
  double a_f = -0.5092;
  double b_f = 1.458;
  double a_s = -0.5092;
  double b_s = 1.458;

  static constexpr auto parameters() { return detail::multirotor_parameters<Multirotor>(); }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> d = {x[3], x[4]}, v_V = {x[5], x[6]};
    const Vec2<S> v_G = rotate(d, v_V);
    const S rate = b_psi * u[3];
    return {v_G.x,
            v_G.y,
            b_z * u[2],
            -(d.y * rate),
            d.x * rate,
            a_f * v_V.x + b_f * u[0],
            a_s * v_V.y - b_s * u[1]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }

  /// Tilt: that of the commanded acceleration. Aerodynamic drag is not part of the thrust.
  template <class S>
  Vec2<S> lean(const std::array<S, nx>&, const std::array<S, nu>& u) const {
    return {(b_f / gravity) * u[0], (-b_s / gravity) * u[1]};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y, 0.0, 0.0};
  }

  /// Rate of the state under an acceleration a in G [m/s^2]. It does not affect the vertical
  /// velocity, which is commanded.
  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({x[3], -x[4]}, {a.x, a.y});
    return {0, 0, 0, 0, 0, a_V.x, a_V.y};
  }

  /// Index of the heading (d_x, d_y) in the state.
  static constexpr int heading_at = 3;
};

/// The same multirotor with the yaw angle psi as a state, (14), (15). It demonstrates the problem
/// that (24) avoids: the angle jumps at pi, and a controller that tracks it there keeps rotating
/// (Fig. 4).
///
///   x = [p_x, p_y, p_z, psi, v_f, v_s]
struct AngleMultirotor {
  static constexpr int nx = 6, nu = 4;
  static constexpr std::string_view name = "angle_multirotor";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "psi", "v_f", "v_s"};
  static constexpr std::array<std::string_view, nu> inputs = Multirotor::inputs;

  double b_z = 1.0, b_psi = 1.6, a_f = -0.5092, b_f = 1.458, a_s = -0.5092, b_s = 1.458;

  static constexpr auto parameters() { return detail::multirotor_parameters<AngleMultirotor>(); }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> v_V = {x[4], x[5]};
    const Vec2<S> v_G = rotate({cos(x[3]), sin(x[3])}, v_V);
    return {v_G.x, v_G.y, b_z * u[2], b_psi * u[3], a_f * v_V.x + b_f * u[0], a_s * v_V.y - b_s * u[1]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {cos(x[3]), sin(x[3])}};
  }

  template <class S>
  Vec2<S> lean(const std::array<S, nx>&, const std::array<S, nu>& u) const {
    return {(b_f / gravity) * u[0], (-b_s / gravity) * u[1]};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, std::atan2(pose.d.y, pose.d.x), 0.0, 0.0};
  }

  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({cos(x[3]), -sin(x[3])}, {a.x, a.y});
    return {0, 0, 0, 0, a_V.x, a_V.y};
  }

  /// Index of the angle psi in the state.
  static constexpr int angle_at = 3;
};

/// A body that is not controlled, a target or an obstacle; its velocity is constant.
///
///   x = [p_x, p_y, p_z, v_x, v_y, v_z]
struct Body {
  static constexpr int nx = 6, nu = 0;
  static constexpr std::string_view name = "body";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "v_x", "v_y", "v_z"};
  static constexpr std::array<std::string_view, nu> inputs = {};

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>&) const {
    return {x[3], x[4], x[5], S(0.0), S(0.0), S(0.0)};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {S(1.0), S(0.0)}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, 0, 0, 0};
  }
};

/// Model of an external robot in the couplings of others: a Body that keeps its heading.
///
///   x = [p_x, p_y, p_z, v_x, v_y, v_z, d_x, d_y]
struct PosedBody {
  static constexpr int nx = 8, nu = 0;
  static constexpr std::string_view name = "posed_body";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "v_x",
                                                              "v_y", "v_z", "d_x", "d_y"};
  static constexpr std::array<std::string_view, nu> inputs = {};

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>&) const {
    return {x[3], x[4], x[5], S(0.0), S(0.0), S(0.0), S(0.0), S(0.0)};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[6], x[7]}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, 0, 0, 0, pose.d.x, pose.d.y};
  }

  /// Index of the heading d in the state.
  static constexpr int heading_at = 6;
};

/// Writes a robot's Sight as the state of a Body or, if x has room for a heading, of a PosedBody.
inline void write_body(const Sight<double>& seen, std::span<double> x) {
  x[0] = seen.p.x, x[1] = seen.p.y, x[2] = seen.p.z;
  x[3] = seen.v.x, x[4] = seen.v.y, x[5] = seen.v.z;
  if (x.size() == PosedBody::nx) x[6] = seen.d.x, x[7] = seen.d.y;
}

}  // namespace sightline
