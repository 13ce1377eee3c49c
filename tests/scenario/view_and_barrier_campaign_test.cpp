// Certified views beside the barrier: a robot whose view others endanger, flights with random motions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/scenario/guarantee.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

constexpr double d_hard = 0.6, d_hard_of_ball = 0.4;  // [m]

/// uav0 observes a ball.
std::string observed_ball(const std::string& motion) {
  return fmt::format(R"(
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
d_hard = {}
motion = {{ {} }}
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
                     d_hard, d_hard_of_ball, motion);
}

/// Two robots fly to and fro through the place, and a body passes where uav0 is.
Scenario crossed_view(Random& random) {
  std::string text = observed_ball(fmt::format(
      "circle = {{ centre = [0.0, 0.0, 1.0], radius = 0.5, rate = {} }}", uniform(random, -0.75, 0.75)));
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

/// The ball is faster than the view assumes, and aims at the observer.
Scenario charged_view(Random& random) {
  const double speed = uniform(random, 0.5, 1.5), aim = uniform(random, 0.0, 1.0);
  std::string text = observed_ball(fmt::format(
      "adversary = {{ agent = \"uav0\", speed = {}, aim = {}, within = \"space\" }}", speed, aim));
  text.replace(
      text.find("[target.ball]"), 13,
      fmt::format("[target.ball]\np = [{}, {}, 1.0]", uniform(random, 0.6, 0.9), uniform(random, -0.3, 0.3)));
  text.replace(text.find("[safety]"), 8, fmt::format("seed = {}\n[safety]", random() % 1000));
  return test::scenario_of(text);
}

/// The distance of two bodies beyond their hard one [m].
double left_of(const Scenario& scenario, BodyId robot, BodyId other, const Sample& sample) {
  const Team& team = scenario.team;
  const double distance = norm(true_sight(team, other, sample).p - true_sight(team, robot, sample).p);
  return distance - (team.name(other) == "ball" ? d_hard_of_ball : d_hard);
}

struct Flown {
  double left = infinity, left_of_guaranteed = infinity;  // of the hard distances [m]
  bool is_lost = false, is_unannounced = false, in_conflict = false;
  long updates = 0, certified = 0, acts = 0;
};

Flown fly(const Scenario& scenario) {
  const Team& team = scenario.team;
  const BodyId uav0 = team.find("uav0"), ball = team.find("ball");
  const std::vector<PairGuarantee> pairs = distance_guarantees(scenario);
  Flown flown;
  std::vector<char> is_kept(pairs.size());  // since the pair was apart: some starts are too near
  bool was_certified = false;
  for (const Sample& sample : test::samples_of(scenario)) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const PairGuarantee& pair = pairs[k];
      const double left = left_of(scenario, pair.first, pair.second, sample);
      is_kept[k] |= left >= 0;
      if (is_kept[k] == 0) continue;
      flown.left = std::min(flown.left, left);
      if (pair.holds()) flown.left_of_guaranteed = std::min(flown.left_of_guaranteed, left);
    }
    bool out = false;
    for (std::size_t k = 0; k < 3; ++k)
      out |= team.couplings()[k].term.potential.violation(true_sight(team, uav0, sample),
                                                          true_sight(team, ball, sample)) > 0;
    flown.is_lost |= out;
    // Certified in the period before, and out of view at its end.
    flown.is_unannounced |= out && was_certified;
    if (sample.of != Sample::Of::update) continue;
    was_certified = sample.views[0].certified;
    for (const BarrierRecord& record : sample.barriers) flown.in_conflict |= record.conflict;
    ++flown.updates, flown.certified += was_certified, flown.acts += sample.barriers[0].active;
  }
  return flown;
}

// Each robot has several neighbours of both kinds, beyond what `check` guarantees.
TEST(ViewAndBarrierCampaign, NoHardDistanceIsBrokenAndNoViewIsLostWithoutAReportBefore) {
  const int flights = runs(300, 30);
  Random random(4);
  int conflicts = 0, lost = 0;
  long updates = 0, certified = 0, acts = 0;
  double least = infinity;
  for (int flight = 0; flight < flights; ++flight) {
    const Flown flown = fly(crossed_view(random));
    EXPECT_GE(flown.left, 0.0) << "flight " << flight;
    EXPECT_FALSE(flown.is_unannounced) << "flight " << flight;
    EXPECT_EQ(flown.left_of_guaranteed, infinity);
    least = std::min(least, flown.left);
    conflicts += flown.in_conflict, lost += flown.is_lost;
    updates += flown.updates, certified += flown.certified, acts += flown.acts;
  }
  std::printf(
      "flights %d, nearest %.4f m beyond d_hard, with a conflict %d, view lost in %d, certified %.3f, "
      "barrier acts %.3f of the time\n",
      flights, least, conflicts, lost, static_cast<double>(certified) / static_cast<double>(updates),
      static_cast<double>(acts) / static_cast<double>(updates));
  EXPECT_GT(lost, 0);
  EXPECT_LT(certified, updates);
}

TEST(ViewAndBarrierCampaign, TheViewYieldsToADistanceThatCheckGuarantees) {
  const int flights = runs(300, 30);
  Random random(5);
  int lost = 0;
  long acts = 0;
  double least = infinity;
  for (int flight = 0; flight < flights; ++flight) {
    const Flown flown = fly(charged_view(random));
    EXPECT_GE(flown.left_of_guaranteed, 0.0) << "flight " << flight;
    EXPECT_LT(flown.left_of_guaranteed, infinity);
    EXPECT_FALSE(flown.is_unannounced) << "flight " << flight;
    EXPECT_FALSE(flown.in_conflict);
    least = std::min(least, flown.left_of_guaranteed);
    lost += flown.is_lost, acts += flown.acts;
  }
  std::printf("flights %d, nearest %.4f m beyond d_hard, view lost in %d, barrier acts in %ld updates\n",
              flights, least, lost, acts);
  EXPECT_GT(lost, 0);
  EXPECT_GT(acts, 0);
}

}  // namespace
}  // namespace sightline
