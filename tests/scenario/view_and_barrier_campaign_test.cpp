// Certified views beside the barrier: a robot whose view others endanger, flights with random motions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "sightline/base.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

constexpr double d_hard = 0.6;  // [m]

/// uav0 observes a ball. Two robots fly to and fro through the place, and a body passes where uav0 is.
Scenario crossed_view(Random& random) {
  std::string text = fmt::format(R"(
[simulation]
duration = 15.0
[safety]
barrier = "on"
d_hard = {}
floor = 0.1
[agent.uav0]
robot = "multirotor"
start = {{ p = [-0.85, 0.0, 1.65], heading = 0.0 }}
sensor = {{ pitch = 0.5, offset = 0.17 }}
R = [0.1, 0.1, 0.1, 0.1]
[target.ball]
d_hard = 0.4
motion = {{ circle = {{ centre = [0.0, 0.0, 1.0], radius = 0.5, rate = {} }} }}
[[couple]]
potential = {{ sensor_cone = {{ alpha = 0.5 }} }}
between = ["uav0", "ball"]
weight = 0.4
[[couple]]
potential = {{ keep_out = {{ d_min = 1.0 }} }}
between = ["uav0", "ball"]
weight = 0.4
[[couple]]
potential = {{ cohesion = {{ d_max = 2.0 }} }}
between = ["uav0", "ball"]
weight = 0.4
[[certify_view]]
observer = "uav0"
target = "ball"
speed_max = 0.4
)",
                                 d_hard, uniform(random, -0.75, 0.75));
  for (int i = 0; i < 2; ++i) {
    const double a = std::numbers::pi * i + uniform(random, -0.5, 0.5), distance = uniform(random, 3.0, 5.0);
    const Vec3<double> p = {distance * std::cos(a), distance * std::sin(a), uniform(random, 1.0, 2.2)};
    text += fmt::format(R"([agent.other{}]
robot = "multirotor"
start = {{ p = [{}, {}, {}], heading = 0.0 }}
Q = [2.0, 2.0, 2.0, 0.2, 0.2, 0.0, 0.0]
reference = {{ waypoints = {{ times = [1.0, {}, 14.0], p = [[{}, {}, {}], [{}, {}, {}], [{}, {}, {}]] }} }}
)",
                        i, p.x, p.y, p.z, uniform(random, 5.0, 9.0), p.x, p.y, p.z, -p.x,
                        -p.y + uniform(random, -0.5, 0.5), uniform(random, 1.0, 2.2), p.x, p.y, p.z);
  }
  const double a = uniform(random, -3.1, 3.1), x = uniform(random, -1.2, 0.2), y = uniform(random, -0.8, 0.8),
               z = uniform(random, 1.4, 2.0);
  text += fmt::format(
      "[obstacle.ram]\nmotion = {{ path = {{ points = [[{}, {}, {}], [{}, {}, {}]], speed = {} }} }}\n",
      x + 6 * std::cos(a), y + 6 * std::sin(a), z, x - 6 * std::cos(a), y - 6 * std::sin(a), z,
      uniform(random, 0.7, 1.5));
  return test::scenario_of(text);
}

TEST(ViewAndBarrierCampaign, NeitherADistanceNorTheViewIsLostWithoutAReportBefore) {
  const int flights = runs(300, 30);
  Random random(4);
  int below = 0, unreported = 0, lost = 0, unannounced = 0;
  long updates = 0, certified = 0, acts = 0;
  double nearest = infinity;
  for (int flight = 0; flight < flights; ++flight) {
    const Scenario scenario = crossed_view(random);
    const Team& team = scenario.team;
    bool is_lost = false, is_unannounced = false, was_certified = false;
    bool in_conflict = false;
    double least = infinity;
    for (const Sample& sample : test::samples_of(scenario)) {
      const auto sight_of = [&](BodyId body) { return true_sight(team, body, sample); };
      const BodyId uav0 = team.find("uav0"), ball = team.find("ball");
      for (int i = 0; i < team.bodies(); ++i) {
        const BodyId other{i};
        if (other != uav0 && other != ball)
          least = std::min(least, norm(sight_of(other).p - sight_of(uav0).p));
      }
      // No guarantee holds beside several robots and bodies; then one of the robots has reported it.
      unreported += least < d_hard && !in_conflict;
      bool out = false;
      for (std::size_t k = 0; k < 3; ++k)
        out |= team.couplings()[k].term.potential.violation(sight_of(uav0), sight_of(ball)) > 0;
      is_lost |= out;
      // Certified in the period before, and out of view at its end.
      is_unannounced |= out && was_certified;
      if (sample.of != Sample::Of::update) continue;
      was_certified = sample.views[0].certified;
      for (const BarrierRecord& record : sample.barriers) in_conflict |= record.conflict;
      ++updates, certified += was_certified, acts += sample.barriers[0].active;
    }
    nearest = std::min(nearest, least);
    below += least < d_hard, lost += is_lost, unannounced += is_unannounced;
  }
  std::printf(
      "flights %d, below d_hard %d, nearest %.3f m, view lost in %d, certified %.3f, barrier acts %.3f of "
      "the time\n",
      flights, below, nearest, lost, static_cast<double>(certified) / static_cast<double>(updates),
      static_cast<double>(acts) / static_cast<double>(updates));
  EXPECT_EQ(unreported, 0);
  EXPECT_LT(5 * below, 2 * flights);
  EXPECT_EQ(unannounced, 0);
  EXPECT_GT(lost, 0);
  EXPECT_LT(certified, updates);
}

}  // namespace
}  // namespace sightline
