// A robot of one's own: a struct with its equations, templates over their scalar; all derivatives are found for it.
#pragma once

#include <sightline/kernels.hpp>

/// A boat with a propeller and a rudder that slides to the side as it turns; x = [p, d, v_f, v_s, r].
struct Boat {
  static constexpr int nx = 8, nu = 2;
  static constexpr std::string_view name = "boat";
  static constexpr int heading_at = 3;  // (d_x, d_y) is a direction, and stays of length 1

  double thrust = 0.9;  ///< forward acceleration per command [m/s^2]
  double rudder = 0.8;  ///< yaw rate per command [rad/s]
  double lag = 0.4;     ///< of the yaw rate [s]
  double drag = 0.6;    ///< along the keel [1/s]; across it five times as much

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const S &d_x = x[3], &d_y = x[4], &v_f = x[5], &v_s = x[6], &r = x[7];
    const S forward = thrust * u[0] - drag * v_f + r * v_s, across = -5.0 * drag * v_s - r * v_f;
    const S turn = (rudder * u[1] - r) / lag;
    return {d_x * v_f - d_y * v_s, d_y * v_f + d_x * v_s, 0.0, -(r * d_y), r * d_x, forward, across, turn};
  }
  template <class S>
  sightline::Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }
  std::array<double, nx> at_rest(const sightline::Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y};
  }
};

/// What `sightline_add_formulas(TARGET own_robot.hpp)` compiles; without that line it is interpreted.
inline void sightline_formulas(sightline::Generator& generator) {
  generator.add(Boat{}, sightline::Seen::pose);
}
