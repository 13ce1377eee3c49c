// Certified views that are handed over, by whole flights with random starts, motions and times.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sightline/judge/safety_summary.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

constexpr double radius = 0.5;  // of the ball's circle [m]

std::string observer(const char* name, const Vec3<double>& p, double heading) {
  return fmt::format(R"(
[agent.{}]
robot = "multirotor"
start = {{ p = [{}, {}, {}], heading = {} }}
sensor = {{ pitch = 0.5, offset = 0.17 }}
R = [0.1, 0.1, 0.1, 0.1]
)",
                     name, p.x, p.y, p.z, heading);
}

std::string view(const char* robot, const char* target) {
  return fmt::format(R"(
[[couple]]
potential = {{ bearing = {{ alpha = 0.5, width = 0.1, tilt = 0.2 }} }}
between = ["{0}", "{1}"]
weight = 4.0
[[couple]]
potential = {{ too_near = {{ d_min = 1.0, kappa = 10.0 }} }}
between = ["{0}", "{1}"]
weight = 4.0
[[couple]]
potential = {{ too_far = {{ d_max = 2.0, kappa = 10.0 }} }}
between = ["{0}", "{1}"]
weight = 8.0
)",
                     robot, target);
}

std::string certified(const char* robot, const char* target) {
  return fmt::format("[[certify_view]]\nobserver = \"{}\"\ntarget = \"{}\"\nspeed_max = 0.4\n", robot,
                     target);
}

/// uav0 observes the ball, until an event turns uav1 to it and uav0 to another place.
std::string handed_over(Random& random, const std::string& views) {
  const double away = uniform(random, -3.1, 3.1), distance = uniform(random, 2.0, 5.0),
               back = uniform(random, -3.1, 3.1), rate = uniform(random, -0.75, 0.75);
  return fmt::format(
      "[simulation]\nduration = 20.0\n{}{}{}", observer("uav0", {radius - 1.35, 0.0, 1.65}, 0.0),
      observer("uav1", {distance * std::cos(away), distance * std::sin(away), uniform(random, 0.5, 2.5)},
               uniform(random, -3.1, 3.1)),
      fmt::format(R"(
[target.ball]
motion = {{ circle = {{ centre = [0.0, 0.0, 1.0], radius = {}, rate = {} }} }}
[obstacle.post]
p = [{}, {}, 1.0]
{}{}
[[event]]
at = {}
observe = [{{ observer = "uav1", target = "ball" }}, {{ observer = "uav0", target = "post" }}]
{}
)",
                  radius, rate, 6 * std::cos(back), 6 * std::sin(back), view("uav0", "ball"),
                  view("uav1", "post"), uniform(random, 1.0, 4.0), views));
}

struct HandedOver {
  int uncertified = 0, unseen = 0;   // updates from the first certified one on; samples
  double waited = 0.0;               // from the event to the end of the first view [s]
  std::vector<EventKind> changes{};  // of the views, in their order
  ViewRecord first{}, second{};      // of the robots at the end
};

HandedOver fly_handover(const std::string& text) {
  const Scenario scenario = test::scenario_of(text);
  const Team& team = scenario.team;
  const BodyId ball{2};
  HandedOver flown;
  bool began = false;
  double happened = 0.0;
  for (const Sample& sample : test::samples_of(scenario)) {
    if (sample.of != Sample::Of::update) continue;
    const auto is_certified = [&](const ViewRecord& record) {
      return record.certified && record.target == ball;
    };
    const auto sees = [&](int robot) {
      const Sight<double> from = true_sight(team, BodyId{robot}, sample), to = true_sight(team, ball, sample);
      return std::all_of(team.couplings().begin(), team.couplings().begin() + 3,
                         [&](const Coupling& c) { return c.term.potential.violation(from, to) <= 0; });
    };
    const bool certified = std::any_of(sample.views.begin(), sample.views.end(), is_certified);
    began |= certified;
    flown.uncertified += began && !certified;
    flown.unseen += began && !sees(0) && !sees(1);
    for (int i = 0; i < sample.event_count; ++i) {
      const Event& event = sample.events[static_cast<std::size_t>(i)];
      if (event.kind == EventKind::event_in_force) happened = event.time;
      if (event.kind == EventKind::view_handed_over) flown.waited = event.time - happened;
      if (event.kind >= EventKind::view_certified) flown.changes.push_back(event.kind);
    }
    flown.first = sample.views[0], flown.second = sample.views[1];
  }
  return flown;
}

TEST(ViewHandover, LeavesNoSampleUncertifiedBetweenTwoObservers) {
  const std::string views = certified("uav0", "ball") + certified("uav1", "ball") + certified("uav0", "post");
  Random random(3);
  double longest = 0.0;
  int both = 0, flights = runs(400, 40);
  for (int flight = 0; flight < flights; ++flight) {
    const HandedOver flown = fly_handover(handed_over(random, views));
    EXPECT_EQ(flown.uncertified, 0) << flight;
    EXPECT_EQ(flown.unseen, 0) << flight;
    EXPECT_EQ(std::count(flown.changes.begin(), flown.changes.end(), EventKind::view_handed_over), 1)
        << flight;
    EXPECT_TRUE(flown.second.certified) << flight;
    EXPECT_EQ(flown.first.target, BodyId{3});
    both += flown.first.certified;
    longest = std::max(longest, flown.waited);
  }
  std::printf("%d hand-overs, %d with both views certified at the end, longest wait %.2f s\n", flights, both,
              longest);
  EXPECT_GT(longest, 0.5);
  EXPECT_GT(2 * both, flights);
}

// The same flights, where the second observer has no certified view to wait for.
TEST(ViewHandover, LeavesAGapWithoutASecondCertifiedView) {
  Random random(3);
  int gaps = 0;
  for (int flight = 0; flight < 4; ++flight)
    gaps += fly_handover(handed_over(random, certified("uav0", "ball"))).uncertified > 0;
  EXPECT_EQ(gaps, 4);
}

}  // namespace
}  // namespace sightline
