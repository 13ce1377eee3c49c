// Certified views in whole flights of the optimal controller, against targets that turn at will and
// at the robot. With the filter and without it; between a floor and a ceiling.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_set.hpp"

namespace sightline {
namespace {

struct ViewedFlight {
  const char* what;
  double speed;  // of the target [m/s]
  int flights;   // of the whole campaign
  bool is_filtered, between_walls;
};

/// A robot in the middle of the set of a target; in two of three flights it is to be elsewhere.
Scenario viewed_target(const ViewedFlight& of, const ViewCertificate& z, Random& random) {
  constexpr double height = 1.0;  // of the target [m]
  // As high or low as walls may be beside the view.
  constexpr double between = 0.3, spare = 1e-3;  // [m]
  const double highest_low = *std::max_element(z.low.begin(), z.low.end()),
               lowest_high = *std::min_element(z.high.begin(), z.high.end()),
               floor = height + (random() % 2 == 0 ? highest_low + spare - between : lowest_high - spare);
  const double r = 0.5 * (z.near + z.far), middle = height + 0.5 * (z.at(z.low, r) + z.at(z.high, r)),
               h = of.between_walls ? std::clamp(middle, floor + spare, floor + between - spare) : middle,
               pull = random() % 3 == 0 ? 0.0 : 4.0;
  std::string text = fmt::format(R"(
[simulation]
duration = 15.0
seed = {}
[agent.uav0]
robot = "multirotor"
start = {{ p = [{}, 0.0, {}], heading = 0.0 }}
sensor = {{ pitch = 0.5, offset = 0.17 }}
Q = [{}, {}, {}, 0.2, 0.2, 0.0, 0.0]
R = [0.1, 0.1, 0.1, 0.1]
reference = {{ constant = {{ p = [{}, {}, {}] }} }}
[target.ball]
p = [0.0, 0.0, {}]
d_hard = 0.4
speed_max = {}
motion = {{ adversary = {{ agent = "uav0", speed = {}, every = {}, aim = {} }} }}
)",
                                 random() % 100000, -r, h, pull, pull, pull, uniform(random, -4, 4),
                                 uniform(random, -4, 4), uniform(random, -1, 4), height, of.speed, of.speed,
                                 uniform(random, 0.1, 3.0), uniform(random, 0.0, 1.0));
  for (const char* limit :
       {"sensor_cone = { alpha = 0.5 }", "keep_out = { d_min = 1.0 }", "cohesion = { d_max = 2.0 }"})
    text += fmt::format("[[couple]]\npotential = {{ {} }}\nbetween = [\"uav0\", \"ball\"]\nweight = 4.0\n",
                        limit);
  if (of.is_filtered)
    text +=
        fmt::format("[[certify_view]]\nobserver = \"uav0\"\ntarget = \"ball\"\nspeed_max = {}\n", of.speed);
  if (of.between_walls)
    text += fmt::format("[safety]\nbarrier = \"on\"\nfloor = {}\nceiling = {}\n", floor, floor + between);
  return test::scenario_of(text);
}

void PrintTo(const ViewedFlight& of, std::ostream* to) { *to << of.what; }

class ViewFlightCampaign : public testing::TestWithParam<ViewedFlight> {};

TEST_P(ViewFlightCampaign, OnlyWithoutTheFilterIsTheTargetLost) {
  const ViewedFlight& of = GetParam();
  const std::vector<Potential> limits = test::cone_limits();
  const ViewTask task = test::view_task(Multirotor{}, {.speed = of.speed}, limits);
  const ViewCertificate z = certify_view(task, ViewSection(view_region(limits, task.motion)));
  Random random(12);
  const int flights = runs(of.flights, of.flights / 10);
  int lost = 0, uncertified = 0, beyond_walls = 0;
  long active = 0, updates = 0;
  for (int flight = 0; flight < flights; ++flight) {
    const Scenario scenario = viewed_target(of, z, random);
    const Team& team = scenario.team;
    bool is_lost = false, was_uncertified = false, is_beyond = false;
    for (const Sample& sample : test::samples_of(scenario)) {
      const Sight<double> robot = true_sight(team, BodyId{0}, sample),
                          ball = true_sight(team, BodyId{1}, sample);
      for (const Potential& limit : limits) is_lost |= limit.violation(robot, ball) > 0;
      if (of.between_walls)
        is_beyond |= robot.p.z < scenario.safety->barrier_options.floor - 1e-6 ||
                     robot.p.z > scenario.safety->barrier_options.ceiling + 1e-6;
      if (sample.of != Sample::Of::update || !of.is_filtered) continue;
      was_uncertified |= !sample.views[0].certified;
      ++updates, active += sample.views[0].active;
    }
    lost += is_lost, uncertified += was_uncertified, beyond_walls += is_beyond;
  }
  std::printf("%-34s flights %d, lost %d, uncertified %d, beyond walls %d, acts in %.3f\n", of.what, flights,
              lost, uncertified, beyond_walls,
              static_cast<double>(active) / static_cast<double>(std::max(1L, updates)));
  EXPECT_EQ(uncertified, 0);
  EXPECT_EQ(beyond_walls, 0);
  if (of.is_filtered) {
    EXPECT_EQ(lost, 0);
  } else {
    EXPECT_GT(3 * lost, flights);
  }
}

INSTANTIATE_TEST_SUITE_P(Flights, ViewFlightCampaign,
                         testing::Values(ViewedFlight{"0.5 m/s", 0.5, 1000, true, false},
                                         ViewedFlight{"0.9 m/s", 0.9, 1000, true, false},
                                         ViewedFlight{"floor and ceiling, 0.5 m/s", 0.5, 3000, true, true},
                                         ViewedFlight{"without the filter, 0.5 m/s", 0.5, 200, false,
                                                      false}));

}  // namespace
}  // namespace sightline
