// Certified views of another robot of the team that is faster than the bound until it is requested
// to slow down.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

/// uav1 flies to and fro between random places, at more than 0.4 m/s; uav0 is to be elsewhere.
std::string restless_target(Random& random, const std::string& keys, double away = 0.0,
                            std::optional<double> heading = {}) {
  std::string times, places;
  for (int i = 1; i < 8; ++i) {
    times += fmt::format("{}{}", i > 1 ? ", " : "", 2 * i);
    places += fmt::format("{}[{}, {}, {}]", i > 1 ? ", " : "", uniform(random, -2, 2), uniform(random, -2, 2),
                          uniform(random, 0.8, 1.2));
  }
  return fmt::format(R"(
[simulation]
duration = 15.0
[agent.uav0]
robot = "multirotor"
start = {{ p = [-1.35, 0.0, 1.65], heading = 0.0 }}
sensor = {{ pitch = 0.5, offset = 0.17 }}
Q = [{0}, {0}, {0}, 0.2, 0.2, 0.0, 0.0]
reference = {{ constant = {{ p = [-4.0, 0.0, 1.5] }} }}
R = [0.1, 0.1, 0.1, 0.1]
[agent.uav1]
robot = "multirotor"
sensor = {{ pitch = 0.5, offset = 0.17 }}
start = {{ p = [0.0, 0.0, 1.0], heading = {1} }}
Q = [4.0, 4.0, 4.0, 0.2, 0.2, 0.0, 0.0]
reference = {{ waypoints = {{ times = [{2}], p = [{3}] }} }}
[[couple]]
potential = {{ bearing = {{ alpha = 0.5, width = 0.1, tilt = 0.2 }} }}
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 4.0
[[couple]]
potential = {{ too_near = {{ d_min = 1.0, kappa = 10.0 }} }}
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 4.0
[[couple]]
potential = {{ too_far = {{ d_max = 2.0, kappa = 10.0 }} }}
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 8.0
[[certify_view]]
observer = "uav0"
target = "uav1"
speed_max = 0.4
{4})",
                     away, heading ? *heading : uniform(random, -3, 3), times, places, keys);
}

struct OnRequest {
  int updates = 0, certified = 0, requested = 0, lost = 0;
  double fastest = 0.0, fast = 0.0;  // speed of the target, and share of the time above speed_max
};

OnRequest fly_on_request(const std::string& text) {
  const Scenario scenario = test::scenario_of(text);
  const Team& team = scenario.team;
  OnRequest flown;
  for (const Sample& sample : test::samples_of(scenario)) {
    if (sample.of != Sample::Of::update) continue;
    const Sight<double> from = true_sight(team, BodyId{0}, sample), to = true_sight(team, BodyId{1}, sample);
    for (std::size_t k = 0; k < 3; ++k)
      flown.lost += team.couplings()[k].term.potential.violation(from, to) > 0;
    const double speed = std::hypot(to.v.x, to.v.y);
    ++flown.updates, flown.certified += sample.views[0].certified,
        flown.requested += sample.views[0].requests;
    flown.fastest = std::max(flown.fastest, speed), flown.fast += speed > 0.401;
  }
  flown.fast /= flown.updates;
  return flown;
}

TEST(ViewsOnRequest, StayCertifiedAtAnyCommandOfATargetThatSlowsDown) {
  const int flights = runs(200, 20);
  Random random(6);
  double fast = 0.0, requested = 0.0;
  for (int flight = 0; flight < flights; ++flight) {
    const char* const keys = flight % 2 == 0 ? "speed_unrequested = 0.9\nrequest_delay = 0.1\n"
                                             : "speed_unrequested = 0.7\nage = 0.05\nwind = 0.1\n";
    const OnRequest flown = fly_on_request(restless_target(random, keys, flight % 4 < 2 ? 4.0 : 0.0));
    EXPECT_EQ(flown.certified, flown.updates) << flight;
    EXPECT_EQ(flown.lost, 0) << flight;
    EXPECT_LE(flown.fastest, flight % 2 == 0 ? 0.9001 : 0.7001) << flight;
    fast += flown.fast / flights, requested += static_cast<double>(flown.requested) / flown.updates / flights;
  }
  std::printf("%d flights: faster than the bound for %.2f of the time, requested for %.2f\n", flights, fast,
              requested);
  EXPECT_GT(fast, 0.1);
  EXPECT_GT(requested, 0.05);
}

TEST(ViewsOnRequest, AreNotCertifiedForTheSameTargetsWithoutRequests) {
  Random random(6);
  int uncertified = 0;
  for (int flight = 0; flight < 5; ++flight) {
    const OnRequest flown = fly_on_request(restless_target(random, ""));
    uncertified += flown.certified < flown.updates;
  }
  EXPECT_EQ(uncertified, 5);
}

TEST(ViewsOnRequest, AreRefusedWhereTheTargetCannotSlowDown) {
  const auto refusal = [](const std::string& keys) {
    Random random(1);
    return refusal_of<ScenarioError>([&] { (void)test::scenario_of(restless_target(random, keys)); });
  };
  EXPECT_TRUE(refusal("speed_unrequested = 0.3\n")
                  .ends_with("expected at least speed_max = 0.4 m/s, which is above 0"));
  EXPECT_TRUE(refusal("speed_unrequested = 0.8\nerror = 0.02\n")
                  .ends_with("expected no such key beside error or acceleration_max"));
  EXPECT_TRUE(refusal("request_delay = 0.1\n").ends_with("expected no such key without speed_unrequested"));
  EXPECT_TRUE(refusal("speed_unrequested = 0.8\nrequest_delay = 2.0\n")
                  .ends_with("expected another view: not even a target at rest can be certified, the thrust "
                             "limits it"));
  // Each of two robots that see each other on request would have to be faster than the other.
  const std::string mutual =
      "speed_unrequested = 0.8\n"
      "[[couple]]\npotential = { sensor_cone = { alpha = 0.5 } }\nbetween = [\"uav1\", \"uav0\"]\n"
      "[[couple]]\npotential = { keep_out = { d_min = 1.0 } }\nbetween = [\"uav1\", \"uav0\"]\n"
      "[[couple]]\npotential = { cohesion = { d_max = 2.0 } }\nbetween = [\"uav1\", \"uav0\"]\n"
      "[[certify_view]]\nobserver = \"uav1\"\ntarget = \"uav0\"\nspeed_max = 0.4\nspeed_unrequested = 0.8\n";
  EXPECT_TRUE(
      refusal(mutual).ends_with("the speed that the observer keeps on request limits what can be "
                                "certified"))
      << refusal(mutual);
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// A second observer of the same target, uav2, from the other side.
/// @param keys  of both views
std::string observed_twice(Random& random, const std::string& keys, const std::string& of_second) {
  const std::string text = restless_target(random, keys, 4.0),
                    first = "start = { p = [-1.35, 0.0, 1.65], heading = 0.0 }";
  const std::size_t robot = text.find("[agent.uav0]"), target = text.find("[agent.uav1]");
  std::string second = text.substr(robot, target - robot) + text.substr(text.find("[[couple]]"));
  second = replaced(second, first, "start = { p = [1.35, 0.0, 1.65], heading = 3.14159 }");
  second = replaced(second, "[-4.0, 0.0, 1.5]", "[4.0, 0.0, 1.5]");
  return text + replaced(replaced(second, "uav0", "uav2"), keys, of_second);
}

// Each request brakes the target further: both see it, at the lower of their speeds.
TEST(ViewsOnRequest, OfOneTargetBySeveralObserversStayCertified) {
  const int flights = runs(100, 20);
  Random random(8);
  int by_first = 0, by_second = 0;
  for (int flight = 0; flight < flights; ++flight) {
    const Scenario scenario = test::scenario_of(observed_twice(
        random, "speed_unrequested = 0.9\nrequest_delay = 0.1\n", "speed_unrequested = 0.7\nage = 0.05\n"));
    const Team& team = scenario.team;
    int uncertified = 0, lost = 0;
    double fastest = 0.0;
    for (const Sample& sample : test::samples_of(scenario)) {
      if (sample.of != Sample::Of::update) continue;
      uncertified += !sample.views[0].certified + !sample.views[2].certified;
      by_first += sample.views[0].requests, by_second += sample.views[2].requests;
      const Sight<double> to = true_sight(team, BodyId{1}, sample);
      fastest = std::max(fastest, std::hypot(to.v.x, to.v.y));
      for (const Coupling& c : team.couplings())
        if (c.name.empty() && c.between.second == BodyId{1})
          lost += c.term.potential.violation(true_sight(team, c.between.first, sample), to) > 0;
    }
    EXPECT_EQ(uncertified, 0) << flight;
    EXPECT_EQ(lost, 0) << flight;
    EXPECT_LE(fastest, 0.7001) << flight;
  }
  std::printf("%d flights: requests by the first %d, second %d\n", flights, by_first, by_second);
  EXPECT_GT(by_first, 0);
  EXPECT_GT(by_second, 0);
}

/// uav1 is requested by uav0, and sees a ball that moves slowly.
std::string chained(Random& random) {
  const std::string keys = "speed_unrequested = 0.9\nrequest_delay = 0.1\n",
                    text = restless_target(random, keys, 4.0, 0.0);
  std::string view = text.substr(text.find("[[couple]]"));
  view = replaced(replaced(view, "\"uav1\"", "\"ball\""), "\"uav0\"", "\"uav1\"");
  view = replaced(replaced(view, "speed_max = 0.4", "speed_max = 0.15\nclimb_max = 0.1"), keys, "");
  return text + view +
         fmt::format(
             "[target.ball]\nmotion = {{ circle = {{ centre = [0.85, 0.0, {}], radius = 0.5, rate = {} }} "
             "}}\n",
             uniform(random, 0.3, 0.5), uniform(random, -0.3, 0.3));
}

TEST(ViewsOnRequest, OfARobotWithACertifiedViewOfItsOwnStayCertifiedWithThatView) {
  const int flights = runs(100, 20);
  Random random(9);
  int requested = 0, active = 0;
  double fast = 0.0;
  for (int flight = 0; flight < flights; ++flight) {
    const Scenario scenario = test::scenario_of(chained(random));
    const Team& team = scenario.team;
    int uncertified = 0, lost = 0, updates = 0, faster = 0;
    double fastest = 0.0;
    for (const Sample& sample : test::samples_of(scenario)) {
      if (sample.of != Sample::Of::update) continue;
      ++updates;
      uncertified += !sample.views[0].certified + !sample.views[1].certified;
      requested += sample.views[0].requests, active += sample.views[1].active;
      for (const Coupling& c : team.couplings())
        if (c.name.empty())
          lost += c.term.potential.violation(true_sight(team, c.between.first, sample),
                                             true_sight(team, c.between.second, sample)) > 0;
      const Sight<double> to = true_sight(team, BodyId{1}, sample);
      const double speed = std::hypot(to.v.x, to.v.y);
      fastest = std::max(fastest, speed), faster += speed > 0.401;
    }
    EXPECT_EQ(uncertified, 0) << flight;
    EXPECT_EQ(lost, 0) << flight;
    EXPECT_LE(fastest, 0.9001) << flight;
    fast += static_cast<double>(faster) / updates / flights;
  }
  std::printf("%d flights: faster than the bound for %.2f of the time, requests %d, own view acts %d\n",
              flights, fast, requested, active);
  EXPECT_GT(requested, 0);
  EXPECT_GT(active, 0);
}

// Beyond the bound it would brake relative to the ball, and follow it faster than it is requested
// to.
TEST(ViewsOnRequest, OfARobotThatFollowsAMeasuredVelocityAreRefused) {
  Random random(9);
  const std::string text =
      replaced(chained(random), "speed_max = 0.15", "speed_max = 1.5\nacceleration_max = 0.3");
  EXPECT_TRUE(test::scenario_refusal(text).ends_with(
      "acceleration_max = 0.3, expected no such key for a robot that another certified view requests to "
      "slow down"))
      << test::scenario_refusal(text);
}

// uav2 sees a post, until an event turns it to uav1 and uav0 to the post.
TEST(ViewsOnRequest, AreHandedOverBetweenObserversThatBothRequest) {
  const int flights = runs(100, 20);
  const std::string keys = "speed_unrequested = 0.8\nrequest_delay = 0.05\n";
  Random random(10);
  int handed_over = 0, waits = 0;
  for (int flight = 0; flight < flights; ++flight) {
    std::string text = observed_twice(random, keys, keys);
    const std::size_t of_second = text.find("between = [\"uav2\"");
    std::string rest = text.substr(of_second);
    const std::size_t view = rest.find("[[certify_view]]");
    rest = replaced(rest.substr(0, view), "\"uav1\"", "\"post\"") + rest.substr(view);
    text = text.substr(0, of_second) + rest +
           fmt::format(
               "[obstacle.post]\np = [{}, {}, 1.0]\n[[event]]\nat = {}\nobserve = [{{ observer = \"uav2\", "
               "target = \"uav1\" }}, {{ observer = \"uav0\", target = \"post\" }}]\n",
               uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, 0.5, 4.0));
    const Scenario scenario = test::scenario_of(text);
    int uncertified = 0;
    bool has_happened = false;
    for (const Sample& sample : test::samples_of(scenario)) {
      if (sample.of != Sample::Of::update) continue;
      uncertified += std::none_of(sample.views.begin(), sample.views.end(), [](const ViewRecord& record) {
        return record.certified && record.target == BodyId{1};
      });
      for (int i = 0; i < sample.event_count; ++i) {
        const EventKind kind = sample.events[static_cast<std::size_t>(i)].kind;
        has_happened |= kind == EventKind::event_in_force, handed_over += kind == EventKind::view_handed_over;
      }
      waits += has_happened && sample.views[0].certified;
    }
    EXPECT_EQ(uncertified, 0) << flight;
  }
  std::printf("%d flights: %d handed over, %d periods waited\n", flights, handed_over, waits);
  EXPECT_GT(2 * handed_over, flights);
  EXPECT_GT(waits, 0);
}

TEST(ViewsOnRequest, OfOneTargetByAnObserverThatRequestsNothingAreRefused) {
  Random random(8);
  const std::string text = observed_twice(random, "speed_unrequested = 0.9\n", "climb_max = 0.3\n");
  EXPECT_TRUE(test::scenario_refusal(text).ends_with(
      "expected speed_unrequested in all certified views of a body, or in none"))
      << test::scenario_refusal(text);
}

TEST(ViewsOnRequest, ATargetWhoseDataWereLostLands) {
  Random random(3);
  const std::string flight = restless_target(random, "speed_unrequested = 0.7\nclimb_max = 0.0\n") +
                             "[safety]\n[safety.supervisor]\n[[simulation.fault]]\nkind = \"dropout\"\n"
                             "body = \"uav1\"\nfrom = 2.0\nuntil = 5.0\n";
  const Scenario scenario = test::scenario_of(flight);
  const Sample last = test::samples_of(scenario).back();
  EXPECT_GE(last.levels[1], FallbackLevel::land);
  EXPECT_LT(true_sight(scenario.team, BodyId{1}, last).p.z, 0.1);
}

TEST(ViewsOnRequest, ATargetThatHoldsIsCertifiedAgain) {
  Random random(3);
  const std::string flight = restless_target(random, "speed_unrequested = 0.9\n", 4.0) +
                             "[[event]]\nat = 0.8\nremove = { agent = \"uav1\", then = \"hold\" }\n";
  const std::vector<Sample> samples = test::samples_of(test::scenario_of(flight));
  EXPECT_TRUE(samples.back().views[0].certified);
}

TEST(ViewsOnRequest, ATargetFasterThanWithoutRequestsIsNotCertified) {
  Random random(3);
  const std::string text =
      replaced(restless_target(random, "speed_unrequested = 0.7\n"), "start = { p = [0.0, 0.0, 1.0], ",
               "start = { p = [0.0, 0.0, 1.0], v = [2.2, 0.0], ");
  const Scenario scenario = test::scenario_of(text);
  const Team& team = scenario.team;
  bool was_certified = false, began = false;
  for (const Sample& sample : test::samples_of(scenario)) {
    if (sample.of != Sample::Of::update) continue;
    if (!std::exchange(began, true)) {
      EXPECT_FALSE(sample.views[0].certified);
    }
    const Sight<double> from = true_sight(team, BodyId{0}, sample), to = true_sight(team, BodyId{1}, sample);
    for (std::size_t k = 0; was_certified && k < 3; ++k)
      EXPECT_LE(team.couplings()[k].term.potential.violation(from, to), 0) << sample.time;
    was_certified = sample.views[0].certified;
  }
}

}  // namespace
}  // namespace sightline
