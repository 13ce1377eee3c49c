/// Flights of section 7.3: starts and obstacles drawn as its ten experiments were.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <variant>

#include "sightline/campaign/evasion.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/random.hpp"

namespace sightline {

inline const EvasionPlan section_7_3 = {
    .agent = "uav0", .target = "target", .obstacle = "hand", .from = 15.0};

/// One flight of a scenario, whatever its duration.
inline EvasionTrace evade(const Scenario& scenario, const EvasionPlan& plan = section_7_3) {
  const auto solver = make_solver(scenario.solver, scenario.team, scenario.horizon);
  const Controllers controllers = {*solver};
  SimulatedClock clock;
  EvasionTrace trace(scenario, plan, sized_sample(scenario.team, controllers));
  const auto world = make_world(scenario);
  ClosedLoop loop(scenario, *world, controllers, clock, trace);
  (void)loop.fly();
  return trace;
}

/// uav0 1 to 1.8 m beside the target, within 60 degrees of its nose, too low to see it. The hand
/// enters anywhere 4 m from the target, at 0.2 m/s to `speed_max`.
inline Scenario with_drawn_start(Scenario scenario, Random& random, double speed_max) {
  using std::numbers::pi;
  const Vec3<double> target{0.04, -0.05, 0.96};
  const double range = uniform(random, 1.0, 1.8), azimuth = uniform(random, -pi, pi);
  const double heading = azimuth + uniform(random, -pi / 3, pi / 3);
  const std::array<double, 7> robot = {target.x - range * std::cos(azimuth),
                                       target.y - range * std::sin(azimuth),
                                       target.z + uniform(random, -0.15, 0.05),
                                       std::cos(heading),
                                       std::sin(heading),
                                       0.0,
                                       0.0};
  std::copy(robot.begin(), robot.end(), scenario.x0.begin());
  auto& hand = std::get<HandMotion>(*scenario.uncooperative.back().motion);
  const double from = uniform(random, -pi, pi);
  hand.from = {target.x + 4 * std::cos(from), target.y + 4 * std::sin(from), 1.2};
  hand.speed = uniform(random, 0.2, speed_max);
  return scenario;
}

}  // namespace sightline
