/// What random scenarios are made of: a new kind of robot, motion, potential, trigger or fault is
/// one line here.
///
/// In a line `$[0.5 2]` stands for a number that is drawn, `$[sine|tangent]` for one of some words.
/// `$[near 2]` is a place up to 2 m from the body; `$[robot]`, `$[observer]` and `$[body]` are
/// names.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace sightline::test {

/// Lists of TOML.
inline std::string list(const std::vector<double>& numbers) {
  return fmt::format("[{:.3f}]", fmt::join(numbers, ", "));
}
inline std::string quoted(const std::vector<std::string>& names) {
  return names.empty() ? "[]" : fmt::format("[\"{}\"]", fmt::join(names, "\", \""));
}

/// A kind of robot: the keys that make it, and what its other keys need to know.
struct DrawnKind {
  std::string_view keys;  // of [agent.NAME]
  std::vector<std::string_view> states;
  std::vector<double> most;  // of each input
  std::string_view
      traits;  // flies, heads, filtered (the barrier takes it), fast (start.v is one of its keys)
  std::string_view text = {};  // [agent.NAME.robot.text]

  bool is(std::string_view trait) const { return traits.find(trait) != std::string_view::npos; }
};

inline const std::vector<DrawnKind>& drawn_kinds() {
  using Words = std::vector<std::string_view>;
  using Most = std::vector<double>;
  constexpr std::string_view copter = "flies heads filtered fast";
  static const Words plane = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f", "v_s"},
                     angle = {"p_x", "p_y", "p_z", "psi", "v_f", "v_s"},
                     lagged = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f", "v_s", "v_z", "r"},
                     hovering = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f", "v_s", "a_f", "a_s", "v_z", "r"},
                     turning = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f", "v_s", "r"},
                     drive = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_f"},
                     point = {"p_x", "p_y", "p_z", "v_x", "v_y", "v_z"},
                     car = {"p_x", "p_y", "p_z", "psi", "v"},
                     drone = {"p_x", "p_y", "p_z", "d_x", "d_y", "v_x", "v_y"},
                     boat = {"north", "east", "depth", "course", "surge"},
                     wing = {"p_x", "p_y", "p_z", "psi", "v", "theta"};
  static const Most one = {1, 1, 1, 1}, px4 = {3, 3, 1, 0.78}, ar_drone = {2.863, 2.863, 1, 1.6};
  static const std::vector<DrawnKind> kinds = {
      {"robot = \"multirotor\"", plane, one, copter},
      {"robot = \"multirotor\"\nparameters = { b_z = 1.5, b_f = 2.0, b_s = 1.2 }", plane, one, copter},
      {"robot = \"angle_multirotor\"", angle, one, copter},
      {"robot = \"velocity_multirotor\"", lagged, px4, "flies heads fast"},
      {"robot = \"velocity_multirotor\"\nparameters = { tau_z = 0.0, tau_psi = 0.0 }", plane, px4, copter},
      {"robot = \"velocity_multirotor\"\nparameters = { preset = \"ar_drone\", tau_z = 0.0, tau_psi = 0.0 }",
       plane, ar_drone, copter},
      {"robot = \"velocity_multirotor\"\nparameters = { preset = \"ar_drone\", tau_z = 0.0 }", turning,
       ar_drone, "flies heads fast"},
      {"robot = \"hover_multirotor\"", plane, one, copter},
      {"robot = \"hover_multirotor\"\nparameters = { preset = \"crazyflie\", tau = 0.07, tau_z = 0.2, "
       "tau_psi = 0.1 }",
       hovering, one, "flies heads fast"},
      {"robot = \"omni_rover\"", plane, {1, 1, 1}, "heads filtered fast"},
      {"robot = \"unicycle\"", drive, {1, 1}, "heads"},
      {"robot = \"point_mass\"\nparameters = { drag = 0.6 }", point, {1, 1, 1}, "flies fast"},
      {"parameters = { drag = 0.5, thrust = 2.0, wheelbase = \"40 cm\", steer_max = \"30 deg\" }",
       car,
       {1, 1},
       "heads",
       R"toml(states = ["p_x", "p_y", "p_z", "psi", "v"]
inputs = ["u", "steer"]
position = ["p_x", "p_y", "p_z"]
heading = "psi"
f.p_x = "v * cos(psi)"
f.p_y = "v * sin(psi)"
f.p_z = 0
f.psi = "v / wheelbase * sin(steer_max * steer)"
f.v = "thrust * u - drag * v")toml"},
      {"parameters = { drag = 0.7 }",
       drone,
       {1.5, 1.5, 0.8, 1.2},
       "flies heads filtered",
       R"toml(states = ["p_x", "p_y", "p_z", "d_x", "d_y", "v_x", "v_y"]
inputs = ["a_x", "a_y", "climb", "turn"]
position = ["p_x", "p_y", "p_z"]
heading = ["d_x", "d_y"]
u_min = [-1.5, -1.5, -0.8, -1.2]
u_max = [1.5, 1.5, 0.8, 1.2]
f.p_x = "v_x"
f.p_y = "v_y"
f.p_z = "climb"
f.d_x = "-d_y * turn"
f.d_y = "d_x * turn"
f.v_x = "a_x - drag * v_x"
f.v_y = "a_y - drag * v_y")toml"},
      {"parameters = { reach = \"1.2 m/s\" }",
       boat,
       {1, 1},
       "heads",
       R"toml(states = ["north", "east", "depth", "course", "surge"]
inputs = ["throttle", "rudder"]
position = ["north", "east", "depth"]
heading = "course"
f.north = "surge * cos(course)"
f.east = "surge * sin(course)"
f.depth = 0
f.course = "rudder"
f.surge = "(reach * throttle - surge) / 0.4")toml"},
      {"parameters = { drag = 0.5, thrust = 2.0 }",
       wing,
       {1, 1, 1},
       "flies heads",
       R"toml(states = ["p_x", "p_y", "p_z", "psi", "v", "theta"]
inputs = ["push", "turn", "pitch"]
position = ["p_x", "p_y", "p_z"]
heading = "psi"
u_min = [-1.0, -1.0, -1.0]
u_max = [1.0, 1.0, 1.0]
f.p_x = "v * cos(psi) * cos(theta)"
f.p_y = "v * sin(psi) * cos(theta)"
f.p_z = "v * sin(theta)"
f.psi = "turn"
f.v = "thrust * push - drag * v"
f.theta = "pitch - theta")toml"},
  };
  return kinds;
}

/// Potentials that look through a sensor, that hold two bodies apart or together, and of one robot
/// alone.
inline constexpr std::array<std::string_view, 4> drawn_views = {
    "bearing = { alpha = $[0.3 1], width = 0.1, tilt = $[0 0.2] }",
    "sensor_cone = { alpha = $[0.3 1], kappa_G = 0.01, form = \"$[sine|tangent]\" }",
    "region = { inside = { all_of = [\"bearing < $[20 60] deg\", \"0.3 m < range < $[2 6] m\"] }, "
    "slope = { softplus = { kappa_G = 1.0, kappa_H = 0.0 } }, kappa_A = 8.0 }",
    "region = { inside = { all_of = [{ limit = \"x > 0\", grows_with = \"range^2\" }, { any_of = "
    "[\"abs(azimuth) < half\", "
    "\"range < $[0.5 1.5] m\"] }] }, parameters = { half = \"$[20 60] deg\" }, slope = { quadratic = { "
    "kappa_G = 0.05 } }, "
    "kappa_A = 4.0, smooth = 0.01 }",
};
inline constexpr std::array<std::string_view, 5> drawn_apart = {
    "too_near = { d_min = $[0.6 1.4], kappa = 10.0 }",
    "keep_out = { d_min = $[0.6 1.4], kappa_H = 4.5, kappa_G = 0.001, kappa_A = 3.0 }",
    "pass_right = { d_min = $[0.7 1.4], delta = $[0 0.5], kappa = 10.0 }",
    "region = { inside = \"distance > $[0.6 1.4] m\", slope = { softplus = { kappa_G = 4.0, kappa_H = $[0 1] "
    "} }, kappa_A = "
    "5.0 }",
    "region = { inside = { any_of = [\"hypot(r_x, r_y) > radius + 0.3\", \"abs(r_z) > $[0.5 1.5] m\"] }, "
    "parameters = { "
    "radius = { value = $[20 80], unit = \"cm\", range = [1.0, 200.0] } }, slope = { softplus = { kappa_G = "
    "4.0, kappa_H = "
    "1.0 } }, kappa_A = 5.0 }",
};
inline constexpr std::array<std::string_view, 4> drawn_together = {
    "too_far = { d_max = $[1.6 5], kappa = $[4 12] }",
    "cohesion = { d_max = $[1.6 5], kappa_H = 1.5, kappa_G = 0.001, kappa_A = 3.0 }",
    "relative_velocity = { v_0 = $[0.5 2] }",
    "region = { inside = { not = \"max(abs(r_x), abs(r_y)) > $[2 5] + 0.05 * t\" }, slope = { softplus = { "
    "kappa_G = 1.0 } "
    "}, smooth = 0.01 }",
};
inline constexpr std::array<std::string_view, 2> drawn_own = {
    "altitude_band = { z_min = $[-0.5 0.8], z_max = $[1.5 4] }",
    "geofence = { low = [$[-8 -4], $[-8 -4], -1.0], high = [$[4 8], $[4 8], 5.0] }",
};

/// How a target or an obstacle moves: [target.NAME].
inline constexpr std::array<std::string_view, 9> drawn_motions = {
    "p = $[near 0]",
    "p = $[near 0]\nspeed_max = $[0 1.5]",
    "p = $[near 0]\nv = [$[-0.3 0.3], $[-0.3 0.3], 0.0]",
    "motion = { circle = { centre = $[near 0.5], radius = $[0.2 1.5], rate = $[-0.6 0.6], phase = $[-3 3] } "
    "}",
    "motion = { path = { points = [$[near 0], $[near 2], $[near 2]], speed = $[0.1 1], end = "
    "\"$[rest|round]\" } }",
    "p = $[near 0]\nmotion = { chase = { agent = \"$[robot]\", speed = $[0.1 1], standoff = $[0 1.5] } }",
    "p = $[near 0]\nmotion = { cross = { agent = \"$[robot]\", at = $[0 10], speed = $[0.3 1.5], miss = $[-1 "
    "1] } }",
    "p = $[near 0]\nmotion = { hand = { agent = \"$[robot]\", at = $[1 10], from = $[near 2], speed = $[0.1 "
    "0.5], standoff "
    "= $[0.7 1.2] } }",
    "p = $[near 0]\nmotion = { adversary = { agent = \"$[robot]\", speed = $[0.2 1.5], every = 0.5, aim = "
    "$[0 1], within = "
    "\"$[plane|space]\" } }",
};

/// What a robot is asked to follow.
inline constexpr std::array<std::string_view, 4> drawn_references = {
    "{ constant = { p = $[near 1] } }",
    "{ circle = { centre = $[near 0.5], radius = $[0 1.5], rate = $[-0.5 0.5] } }",
    "{ waypoints = { times = [2.0, $[6 18]], p = [$[near 0.5], $[near 3]], heading = [$[-3 3], $[-3 3]] } }",
    "{ steps = { times = [0.0, $[3 15]], p = [$[near 0.5], $[near 2]] } }",
};

/// Triggers other than a time; those of the second list need a robot with a sensor.
inline constexpr std::array<std::string_view, 6> drawn_triggers = {
    "when = { distance = [\"$[robot]\", \"$[body]\"], $[below|above] = $[1 4], hysteresis = 0.2 }",
    "when = { age = \"$[body]\", above = $[0.1 1] }",
    "when = { formula = \"$[observer.p_z|norm(observer.v_x, observer.v_y)|t]\", agent = \"$[robot]\", above "
    "= $[0.5 3] }",
    "when = { formula = \"target.v_x + k\", between = [\"$[robot]\", \"$[body]\"], parameters = { k = $[-1 "
    "1] }, below = "
    "$[0 1], dwell = $[0 1] }",
    "when = { region = { all_of = [\"distance > $[1 3] m\", \"r_z < 5\"] }, between = [\"$[robot]\", "
    "\"$[body]\"] }",
    "signal = \"$[go|back]\"",
};
inline constexpr std::array<std::string_view, 4> drawn_sights = {
    "when = { angle = [\"$[observer]\", \"$[body]\"], above = $[0.2 2], hysteresis = 0.1 }",
    "lost = { observer = \"$[observer]\", target = \"$[body]\", alpha = $[0.3 1], dwell = $[0 1] }",
    "seen = { observer = \"$[observer]\", target = \"$[body]\", alpha = $[0.3 1], hysteresis = 0.1 }",
    "when = { region = \"bearing < $[0.3 1]\", between = [\"$[observer]\", \"$[body]\"], dwell = $[0 0.5] }",
};

/// [[simulation.fault]]: chance alone does not keep data away for long, unless all of them.
inline constexpr std::array<std::string_view, 10> drawn_faults = {
    "kind = \"dropout\"\nprobability = $[0.05 0.5]",
    "kind = \"dropout\"",
    "kind = \"dropout\"\nbody = \"$[body]\"",
    "kind = \"delay\"\ndelay = $[0 0.6]",
    "kind = \"delay\"\nbody = \"$[body]\"\ndelay = $[0 3]",
    "kind = \"freeze\"\nbody = \"$[body]\"",
    "kind = \"nan\"\nprobability = $[0.05 0.5]",
    "kind = \"nan\"\nbody = \"$[body]\"",
    "kind = \"jump\"\nprobability = $[0.05 0.4]\noffset = [$[-3 3], $[-3 3], $[0 1]]",
    "kind = \"late_plan\"\ndelay = $[0.01 0.6]",
};

inline constexpr std::array<std::string_view, 2> drawn_sensors = {
    "{ pitch = $[-0.2 0.6], offset = $[0 0.2] }",
    "{ yaw = $[-3 3], pitch = $[-1.5 1.5], roll = $[-3 3], offset = [$[-0.2 0.2], $[-0.2 0.2], $[-0.1 0.1]] "
    "}",
};

inline constexpr std::array<std::string_view, 7> drawn_disturbances = {
    "wind = [$[-0.2 0.2], $[-0.2 0.2], 0.0]",
    "gust = { sigma = $[0.01 0.2], time = 1.0 }",
    "airflow = { amplitude = $[0.05 0.2], distance = 1.5, frequency = 0.5 }",
    "input_delay = $[0.01 0.1]",
    "noise = { position = $[0.001 0.02], heading = $[0.001 0.02], velocity = $[0 0.02] }",
    "odometry = { position_bias = $[0 0.02], position_walk = $[0 0.005], heading_walk = $[0 0.005] }",
    "delay = $[0.01 0.15]",
};

/// Control periods [s], and what makes up for late commands and wind.
inline constexpr std::array<std::string_view, 9> drawn_periods = {"0.001", "0.002", "0.005", "0.01", "0.02",
                                                                  "0.05",  "0.1",   "0.2",   "0.5"};
inline constexpr std::array<std::string_view, 3> drawn_compensation = {
    "disturbance_time = $[0.1 1]", "command_delay = $[0 0.3]", "feed_forward = \"reference\""};

/// Of [[keep_apart]], and limits of states and inputs of one robot.
inline constexpr std::array<std::string_view, 2> drawn_swarms = {
    "too_near = { d_min = $[0.6 1.2], kappa = 10.0 }", "keep_out = { d_min = $[0.6 1.2] }"};
inline constexpr std::array<std::string_view, 2> drawn_limits = {"speed = { max = $[1 2.5] }",
                                                                 "input_disc = { radius = $[0.6 1.2] }"};

}  // namespace sightline::test
