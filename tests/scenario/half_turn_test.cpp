/// A half turn as a scenario has it: in its reference, or as an event.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sightline/registry.hpp"
#include "tests/support/scenario_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

constexpr double deg = pi / 180;

/// How far uav0, the first body, has turned to the left between two times [rad].
double turned(const TeamFlight& flight, double from, double until) {
  double sum = 0.0;
  for (std::size_t k = 1; k < flight.flown.size(); ++k) {
    if (flight.flown[k].time <= from || flight.flown[k].time > until + 1e-9) continue;
    const std::vector<double>&a = flight.flown[k - 1].x, &b = flight.flown[k].x;
    sum += std::atan2(a[3] * b[4] - a[4] * b[3], a[3] * b[3] + a[4] * b[4]);
  }
  return sum;
}

std::string scenario_text(const std::string& reference, const std::string& more = {}) {
  return fmt::format(
      "[agent.uav0]\nrobot = \"multirotor\"\nstart = {{ p = [0.0, 0.0, 1.0], heading = 0.0 }}\n"
      "Q = [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]\nreference = {}\n{}\n[simulation]\nduration = 8.0\n",
      reference, more);
}

TEST(HalfTurnOfAScenario, AStepOfPiTurnsTheRobot150DegreesIn3SecondsWhateverTheSolver) {
  for (const std::string_view name : solver_names()) {
    for (const std::string heading : {"3.141592653589793", "-3.141592653589793", "3.141592654", "3.13"}) {
      Scenario scenario = test::scenario_of(scenario_text(
          "{ steps = { times = [0.0, 4.0], p = [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]], heading = [0.0, " +
          heading + "] } }"));
      scenario.solver = solver_named(name);
      const TeamFlight flight = fly_scenario(scenario);
      EXPECT_NEAR(turned(flight, 0.0, 3.0), 0.0, 1e-9) << name;  // before the horizon sees the step
      EXPECT_GE(turned(flight, 0.0, 7.0), 150 * deg) << name << " " << heading;
      EXPECT_LE(turned(flight, 0.0, 7.0), 181 * deg) << name << " " << heading;
    }
  }
}

TEST(HalfTurnOfAScenario, AnEventTurnsTheRobotToo) {
  const std::string here = "{ constant = { p = [0.0, 0.0, 1.0], heading = 0.0 } }";
  for (const std::string there :
       {"{ constant = { p = [0.0, 0.0, 1.0], heading = 3.141592653589793 } }",
        "{ state = [0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0] }",
        "{ waypoints = { times = [0.0], p = [[0.0, 0.0, 1.0]], heading = [-3.141592653589793] } }"}) {
    for (const std::string ramp : {"0.0", "1.0"}) {
      const TeamFlight flight = fly_scenario(test::scenario_of(
          scenario_text(here, "[[event]]\nat = 4.0\nramp = " + ramp +
                                  "\nreference = { agent = \"uav0\", reference = " + there + " }\n")));
      EXPECT_NEAR(turned(flight, 0.0, 4.0), 0.0, 1e-9);
      EXPECT_GE(turned(flight, 4.0, 7.0), 150 * deg) << there << " " << ramp;
      EXPECT_LE(turned(flight, 4.0, 7.0), 181 * deg) << there << " " << ramp;
    }
  }
}

TEST(HalfTurnOfAScenario, FeedForwardTurnsTheRobotToTheSameSide) {
  for (const double heading : {0.0, 0.3, 1.0, -2.0}) {
    for (const double half : {pi, -pi}) {
      const TeamFlight flight = fly_scenario(
          test::scenario_of(scenario_text(fmt::format("{{ steps = {{ times = [0.0, 4.0], p = [[0.0, 0.0, "
                                                      "1.0], [0.0, 0.0, 1.0]], heading = [{0}, {1}] }} }}\n"
                                                      "feed_forward = \"reference\"",
                                                      heading, heading + half))));
      EXPECT_GE(turned(flight, 3.0, 7.0), 150 * deg) << heading << " " << half;
      EXPECT_LE(turned(flight, 3.0, 7.0), 190 * deg) << heading << " " << half;
    }
  }
}

}  // namespace
}  // namespace sightline
