#include "sightline/world/localized_world.hpp"

#include <gtest/gtest.h>

#include "sightline/potential/bearing.hpp"
#include "sightline/potential/slope.hpp"
#include "sightline/potential/tracking.hpp"
#include "sightline/solver/newton/newton_riccati.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/synthetic_flight.hpp"
#include "tests/support/tag_world.hpp"

namespace sightline {
namespace {

using test::TagWorld;

constexpr double flight_period = 0.01;

/// A body on a slow slow_figure.
std::array<double, 7> slow_figure(double t) {
  return {0.8 * std::cos(0.4 * t), 0.8 * std::sin(0.3 * t), 1.2 + 0.2 * std::sin(0.3 * t), 1, 0, 0, 0};
}

/// Robots in a row behind one that flies the slow_figure, each keeps the one before it in view.
Team followers(int robots) {
  Team team;
  std::vector<AgentId> all;
  for (int i = 0; i < robots; ++i) {
    const std::string name = "uav" + std::to_string(i);
    if (i == 0) {
      all.push_back(team.add(
          Multirotor{}, {.Q = {1.5, 1.5, 1.6, 1, 1}, .R = {1, 1, 1, 1}, .x_ref = slow_figure, .name = name}));
      continue;
    }
    all.push_back(team.add(Multirotor{}, {.R = {.1, .1, .1, .1}, .name = name}));
    const Between pair{all.back(), all[all.size() - 2]};
    const auto feels = felt_by(all.back());
    team.couple(4.0 * Bearing{.alpha = 0.5, .width = 0.1, .tilt = 0.2}, pair, feels);
    team.couple(4.0 * TooNear{.d_min = 1.0, .kappa = 10}, pair, feels);
    team.couple(8.0 * TooFar{.d_max = 2.0, .kappa = 10}, pair, feels);
    team.couple(0.1 * RelativeVelocity{.v_0 = 1.0}, pair, feels);
  }
  return team;
}
std::vector<double> in_a_row(int robots) {
  std::vector<double> x;
  for (int i = 0; i < robots; ++i)
    for (const double v : {0.8 + 1.5 * i, 0.0, 1.2 + 0.5 * i, i == 0 ? 1.0 : -1.0, 0.0, 0.0, 0.0})
      x.push_back(v);
  return x;
}

struct LocalizedFlight {
  std::vector<test::Consistency> robots;  // those that are localized
  double longest_out_of_view = 0.0;       // of any of them
  double known_from = -1.0;               // all of them
  double blind_sigma = 0.0;               // greatest [m]
  std::vector<double> end;                // true states
};

LocalizedFlight fly_localized(LocalizedWorld& world, double duration, double from = 5.0) {
  const Team& team = world.team();
  NewtonRiccati solver(Ocp(team, {.T = 1.0, .N = 20, .dt = flight_period}));
  LocalizedFlight flown;
  flown.robots.resize(world.estimates().size());
  std::vector<double> rest(static_cast<std::size_t>(team.nu())), u = rest, out(flown.robots.size());
  for (int k = 0; k < std::lround(duration / flight_period); ++k) {
    const double t = k * flight_period;
    const Measured now = world.measure(t);
    bool all_known = true;
    for (std::size_t i = 0; i < flown.robots.size(); ++i) {
      const PoseEstimate& estimate = world.estimates()[i];
      all_known = all_known && estimate.known;
      const BodyId body{static_cast<int>(i) + 1};
      const auto sight = [&](BodyId of) {
        return team.model(of).sight(&now.truth[static_cast<std::size_t>(team.state_offset(of))], rest.data());
      };
      const Sight<double> own = sight(body), other = sight(BodyId{body.index - 1});
      out[i] = view_angle(SensorMount{}, static_cast<const Pose<double>&>(own), other.p) > 0.5
                   ? out[i] + flight_period
                   : 0.0;
      if (t < from) continue;
      flown.longest_out_of_view = std::max(flown.longest_out_of_view, out[i]);
      if (!estimate.known) ++flown.robots[i].unknown;
      if (estimate.known) {
        flown.robots[i].add(estimate, {.p = own.p, .psi = std::atan2(own.d.y, own.d.x)});
        flown.blind_sigma = std::max(flown.blind_sigma, estimate.position_sigma());
      }
    }
    if (all_known && flown.known_from < 0) flown.known_from = t;
    // Until all are known they hold.
    if (flown.known_from >= 0) {
      const Solution solution = solver.solve(t, now.measured);
      std::copy(solution.u.begin(), solution.u.end(), u.begin());
    }
    flown.end.assign(now.truth.begin(), now.truth.end());
    EXPECT_TRUE(world.apply(t, now.measured, u, flight_period, 1));
  }
  return flown;
}

/// uav1 and those behind it have no positions.
std::unique_ptr<LocalizedWorld> localized(int robots, FilterKind kind, std::uint64_t seed,
                                          TagWorld::Hidden hidden = {1e9, 1e9}) {
  std::vector<TagWorld::Camera> cameras;
  LocalizationOptions options{.seed = seed};
  for (int i = 1; i < robots; ++i) {
    cameras.push_back({BodyId{i}, BodyId{i - 1}, SensorMount{}});
    options.robots.push_back({.robot = BodyId{i},
                              .watches = {BodyId{i - 1}},
                              .filter = {.filter = kind, .other_error_time = 0.5}});
  }
  PlantOptions plant{.seed = seed};
  plant.disturbances.gust_sigma = 0.3;
  return std::make_unique<LocalizedWorld>(
      std::make_unique<TagWorld>(followers(robots), in_a_row(robots), cameras, plant, hidden), options);
}

TEST(LocalizedWorld, ARobotThatSeesNothingButItsNeighbourFliesByWhatItSees) {
  for (const FilterKind kind : {FilterKind::heading, FilterKind::attitude}) {
    test::Consistency all;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const auto world = localized(2, kind, seed);
      const LocalizedFlight flown = fly_localized(*world, 20.0);
      EXPECT_LT(flown.longest_out_of_view, 0.5) << seed;
      EXPECT_LT(flown.known_from, 0.5) << seed;
      EXPECT_EQ(flown.robots[0].unknown, 0) << seed;
      all.squares += flown.robots[0].squares, all.nees += flown.robots[0].nees;
      all.samples += flown.robots[0].samples;
    }
    EXPECT_LT(all.rmse(), kind == FilterKind::heading ? 0.025 : 0.012);
    EXPECT_GT(all.anees(), 2.5);
    EXPECT_LT(all.anees(), 5.5);
  }
}

TEST(LocalizedWorld, HiddenForTwoSecondsItFliesOnAndFindsTheTargetAgain) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto world = localized(2, FilterKind::heading, seed, {.from = 8.0, .until = 10.0});
    const LocalizedFlight flown = fly_localized(*world, 16.0);
    EXPECT_LT(flown.longest_out_of_view, 0.5) << seed;
    EXPECT_GT(flown.blind_sigma, 0.05) << "it says that it does not know";
    EXPECT_LT(world->estimates()[0].position_sigma(), 0.04);
  }
}

TEST(LocalizedWorld, AChainOfRobotsHangsOnOneThatKnowsItsPose) {
  test::Consistency last;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto world = localized(4, FilterKind::heading, seed);
    const LocalizedFlight flown = fly_localized(*world, 20.0);
    EXPECT_LT(flown.longest_out_of_view, 0.5) << seed;
    last.squares += flown.robots[2].squares, last.nees += flown.robots[2].nees;
    last.samples += flown.robots[2].samples;
  }
  EXPECT_LT(last.rmse(), 0.03);
  EXPECT_LT(last.anees(), 6.0);
}

TEST(LocalizedWorld, BeforeItHasSeenAnythingARobotIsNowhere) {
  const auto world = localized(2, FilterKind::heading, 3);
  const Measured first = world->measure(0.0);
  EXPECT_EQ(first.stamps[1], -std::numeric_limits<double>::infinity());
  EXPECT_EQ(first.stamps[0], 0.0);
  EXPECT_FALSE(world->estimates()[0].known);
}

TEST(LocalizedWorld, AnEstimateThatIsNotGoodEnoughGrowsOld) {
  const auto world = localized(2, FilterKind::heading, 4, {.from = 4.0, .until = 60.0});
  const std::vector<double> u(8);
  double stamp = 0.0, t = 0.0;
  for (; t < 30.0; t += flight_period) {
    const Measured now = world->measure(t);
    stamp = now.stamps[1];
    (void)world->apply(t, now.measured, u, flight_period, 1);
  }
  EXPECT_GT(world->estimates()[0].position_sigma(), 0.5);
  EXPECT_LT(stamp, t - 5.0);
  EXPECT_GT(stamp, 4.5);
}

TEST(LocalizedWorld, SameSeedSameBits) {
  const auto end = [](std::uint64_t seed) {
    return fly_localized(*localized(3, FilterKind::heading, seed), 6.0).end;
  };
  const std::vector<double> first = end(5);
  EXPECT_EQ(first, end(5));
  EXPECT_NE(first, end(6));
}

TEST(LocalizedWorld, OneThatComesAgainBeginsAnew) {
  const auto world = localized(2, FilterKind::heading, 6);
  std::vector<double> u(8);
  const auto until = [&](double from, double end) {
    for (double t = from; t < end; t += flight_period) {
      const Measured now = world->measure(t);
      (void)world->apply(t, now.measured, u, flight_period, 1);
    }
  };
  until(0.0, 1.0);
  EXPECT_TRUE(world->estimates()[0].known);
  world->set_presence(std::vector{Presence::steered, Presence::absent});
  EXPECT_FALSE(world->estimates()[0].known);
  world->set_presence(std::vector{Presence::steered, Presence::steered});
  EXPECT_EQ(world->measure(1.0).stamps[1], -std::numeric_limits<double>::infinity());
  until(1.0, 2.0);
  EXPECT_TRUE(world->estimates()[0].known);
}

TEST(LocalizedWorld, WhatCannotBeLocalizedIsRefused) {
  const auto refused = [](LocalizationOptions options) {
    return refusal_of([&] {
      LocalizedWorld(std::make_unique<TagWorld>(followers(3), in_a_row(3), std::vector<TagWorld::Camera>{}),
                     options);
    });
  };
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{1}, .watches = {BodyId{2}}},
                                {.robot = BodyId{2}, .watches = {BodyId{1}, BodyId{0}}}}}),
            "robots are localized in a circle, \"uav1\" by \"uav2\", \"uav2\" by \"uav1\", expected none: "
            "information would be counted "
            "twice");
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{1}}}}),
            "\"uav1\" is localized by nobody who is localized, expected a path from it to a robot whose pose "
            "is known");
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{1}, .watches = {BodyId{0}}},
                                {.robot = BodyId{2},
                                 .watches = {BodyId{1}},
                                 .filter = {.filter = FilterKind::attitude}}}}),
            "\"uav2\" watches \"uav1\", which is localized itself, with the filter \"attitude\", expected "
            "\"heading\"");
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{1}, .watches = {BodyId{0}}}}, .sigma_hold = 0.0}),
            "estimate.sigma_hold = 0, expected > 0 m");
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{7}, .watches = {BodyId{0}}}}}),
            "a robot that is localized has the number 7, expected one of 3 bodies");
}

}  // namespace
}  // namespace sightline
