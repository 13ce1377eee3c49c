#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

using Numbers = std::vector<double>;

Team two_robots() {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  team.add(Multirotor{}, {.name = "b"});
  team.add(Obstacle{.name = "wall"});
  return team;
}
const Numbers start_of_both = {0, 0, 1, 1, 0, 0, 0, /**/ 4, 0, 1, 1, 0, 0, 0, /**/ 2, 3, 1, 0, 0, 0};

// A flight under one command for both robots; the true states are measured, with the time of the
// moment.
struct GuardedFlight {
  explicit GuardedFlight(const GuardOptions& options, const Numbers& command = {1, 0, 0, 0, -1, 0, 0, 0})
      : guard(team, options), requested(command) {}

  void step(bool seen = true) {
    if (seen) {
      measured.assign(plant.x().begin(), plant.x().end());
      stamps.assign(3, t);
    }
    const ValidStates& estimate = guard.accept_measurement(t, measured, stamps, sigmas);
    estimated = estimate;
    if (!views.empty()) guard.look(t, views);
    u = requested;
    guard.fall_back(t, estimate, Numbers(3, 0.0), Numbers(u.size()), u);
    guard.keep_distances(t, estimate, Numbers(u.size()), u);
    guard.record(t, u);
    events.insert(events.end(), guard.events().begin(), guard.events().end());
    EXPECT_TRUE(plant.step(u, 0.01));
    t += 0.01;
    const auto x = plant.x();
    nearest = std::min(nearest, std::hypot(x[0] - x[7], x[1] - x[8], x[2] - x[9]));
    lowest = std::min(lowest, x[2]);
  }

  Team team = two_robots();
  Guard guard;
  Membership membership = ActiveTeam(team).membership();
  Plant plant{team, start_of_both};
  Numbers measured = start_of_both, stamps = Numbers(3, 0.0), sigmas{}, requested, u;
  std::span<const View> views{};
  std::span<const double> estimated;
  std::vector<Event> events;
  double t = 0.0, nearest = 1e9, lowest = 1e9;
};

TEST(Guard, KeepsOffNobodyWhoIsAbsent) {
  for (const bool absent : {false, true}) {
    GuardedFlight flight({.barrier = BarrierMode::on});
    if (absent) {
      flight.membership.presence[1] = Presence::absent;
      flight.guard.follow(flight.membership, 0.0, start_of_both);
    }
    for (int k = 0; k < 400; ++k) {
      flight.step();
      EXPECT_FALSE(absent && flight.guard.barriers()[1].active);
    }
    EXPECT_EQ(flight.nearest < 0.6, absent) << flight.nearest;
  }
}

TEST(Guard, WithNeitherSupervisorNorBarrierAllStaysBitForBit) {
  GuardedFlight flight({});
  for (int k = 0; k < 100; ++k) {
    const Numbers x(flight.plant.x().begin(), flight.plant.x().end());
    flight.step();
    ASSERT_EQ(Numbers(flight.estimated.begin(), flight.estimated.end()), x);
    ASSERT_EQ(flight.u, flight.requested);
  }
  EXPECT_TRUE(flight.events.empty());
  EXPECT_TRUE(flight.guard.barriers().empty());
  EXPECT_TRUE(flight.guard.knows_all());
}

TEST(Guard, TheBarrierKeepsRobotsApartThatAreSentAtEachOther) {
  GuardedFlight flight({.barrier = BarrierMode::on, .bodies = {{.d_hard = 0.8}, {.d_hard = 0.8}, {}}});
  bool active = false;
  for (int k = 0; k < 600; ++k) {
    flight.step();
    active |= flight.guard.barriers()[0].active;
  }
  EXPECT_TRUE(active);
  EXPECT_GE(flight.nearest, 0.8);
  EXPECT_LT(flight.nearest, 1.2) << "and lets them as near as they may";
}

TEST(Guard, WhoHasRoomGivesWayForARobotThatHasNone) {
  // The world ends behind b, which stays.
  GuardedFlight flight({.barrier = BarrierMode::on,
                        .barrier_options = {.world = 4.05},
                        .bodies = {{.d_hard = 0.8}, {.d_hard = 0.8}, {}}},
                       {1, 0, 0, 0, 0, 0, 0, 0});
  for (int k = 0; k < 600; ++k) flight.step();
  EXPECT_GE(flight.nearest, 0.8);
  EXPECT_LT(flight.nearest, 1.2);
}

/// Hears nobody from some time on.
struct Deaf final : Connectivity {
  bool receives_from(BodyId, BodyId) const noexcept override { return connectivity; }
  bool is_received(BodyId body) const noexcept override { return connectivity || body.index != 1; }
  bool connectivity = true;
};

TEST(Guard, WhoIsNotHeardIsUncooperativeAndKeptFartherAway) {
  std::array<double, 2> nearest{};
  for (const bool connectivity : {true, false}) {
    GuardedFlight flight({.barrier = BarrierMode::on});
    Deaf ears;
    ears.connectivity = connectivity;
    flight.guard.set_connectivity(&ears);
    for (int k = 0; k < 400; ++k) flight.step();
    nearest[connectivity] = flight.nearest;
    const auto tells = [&](EventKind kind) {
      return std::count_if(flight.events.begin(), flight.events.end(),
                           [&](const Event& event) { return event.kind == kind; });
    };
    EXPECT_EQ(tells(EventKind::stale), connectivity ? 0 : 1);
    ears.connectivity = true;
    flight.step();
    EXPECT_EQ(tells(EventKind::received), connectivity ? 0 : 1);
    EXPECT_GE(flight.nearest, 0.6);
  }
  EXPECT_GT(nearest[0], nearest[1] + 0.1);
}

TEST(Guard, ARobotOfAnotherPartIsAMemberWhileItIsHeard) {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  team.add(Obstacle{.name = "b"});
  const Numbers start = {0, 0, 1, 1, 0, 0.8, 0, /**/ 2, 0, 1, -0.8, 0, 0};
  std::array<bool, 3> active{};
  for (int which = 0; which < 3; ++which) {
    Guard guard(team, {.barrier = BarrierMode::on,
                       .bodies = {{}, {.robot = which == 2 ? "unicycle" : "multirotor"}}});
    Deaf ears;
    ears.connectivity = which != 1;
    guard.set_connectivity(&ears);
    const ValidStates& x = guard.accept_measurement(0.0, start, Numbers(2, 0.0));
    Numbers u = {1, 0, 0, 0};
    guard.fall_back(0.0, x, Numbers(2, 0.0), Numbers(4), u);
    guard.keep_distances(0.0, x, Numbers(4), u);
    active[at(which)] = guard.barriers()[0].active;
  }
  EXPECT_FALSE(active[0]) << "it gives way as well";
  EXPECT_TRUE(active[1]) << "it is not heard";
  EXPECT_TRUE(active[2]) << "of another model it never is a member";
}

TEST(Guard, ABarrierThatOnlyReportsChangesNothing) {
  GuardedFlight flight({.barrier = BarrierMode::report, .bodies = {{.d_hard = 0.8}, {.d_hard = 0.8}, {}}});
  bool active = false;
  for (int k = 0; k < 250; ++k) {
    flight.step();
    ASSERT_EQ(flight.u, flight.requested);
    active |= flight.guard.barriers()[0].active;
  }
  EXPECT_TRUE(active);
  EXPECT_LT(flight.nearest, 0.5);
}

TEST(Guard, TheFloorIsKeptUntilARobotLandsAndAGroundedOneIsLeftAlone) {
  const BarrierOptions floor{.floor = 0.5};
  GuardedFlight down(
      {.supervisor = SupervisorOptions{}, .barrier = BarrierMode::on, .barrier_options = floor},
      {0, 0, -1, 0, 0, 0, 0, 0});
  for (int k = 0; k < 300; ++k) down.step();
  EXPECT_GE(down.lowest, 0.5 - 1e-9);
  for (int k = 0; k < 900; ++k) down.step(false);
  EXPECT_EQ(down.guard.supervisor()->level(BodyId{0}), FallbackLevel::grounded);
  EXPECT_NEAR(down.plant.x()[2], 0.0, 0.03);
  for (int k = 0; k < 300; ++k) down.step();
  EXPECT_NEAR(down.plant.x()[2], 0.0, 0.03);
}

TEST(Guard, ARobotThatIsToldToLandPassesTheFloor) {
  for (const bool supervised : {false, true}) {
    GuardOptions options{.barrier = BarrierMode::on, .barrier_options = {.floor = 0.5}};
    if (supervised) options.supervisor = SupervisorOptions{};
    GuardedFlight flight(options, {0, 0, -0.3, 0, 0, 0, -0.3, 0});
    flight.membership.presence[0] = Presence::land;
    flight.guard.follow(flight.membership, 0.0, start_of_both);
    for (int k = 0; k < 300; ++k) flight.step();
    EXPECT_LT(flight.lowest, 0.2);
    EXPECT_GE(flight.plant.x()[9], 0.5 - 1e-9) << "the other is steered";
  }
}

TEST(Guard, LimitsThatAreRetunedInFlightHoldForBarrierAndSupervisor) {
  const InputLimits narrow({-0.2, -0.2, -0.2, -0.2}, {0.2, 0.2, 0.2, 0.2});
  GuardedFlight flight({.supervisor = SupervisorOptions{},
                        .barrier = BarrierMode::on,
                        .bodies = {{.d_hard = 0.8}, {.d_hard = 0.8}, {}},
                        .limits_to_come = {{BodyId{0}, narrow}}},
                       {0.2, 0, 0, 0, -1, 0, 0, 0});
  bool active = false;
  for (int k = 0; k < 600; ++k) {
    if (k == 50) {
      flight.membership.limits[0] = narrow;
      flight.guard.follow(flight.membership, flight.t, start_of_both);
    }
    flight.step(k < 400);  // then the supervisor brakes
    active |= flight.guard.barriers()[0].active;
    for (std::size_t i = 0; k >= 50 && i < 4; ++i) ASSERT_LE(std::abs(flight.u[i]), 0.2) << k;
  }
  EXPECT_TRUE(active);
  EXPECT_GE(flight.nearest, 0.8) << "it began early enough for the limits to come";
}

TEST(Guard, LimitsToComeThatExcludeEachOtherAreRefused) {
  const Team team = two_robots();
  const InputLimits other({0.5, -1, -1, -1}, {1, 1, 1, 1}), one({-1, -1, -1, -1}, {0.4, 1, 1, 1});
  EXPECT_THROW(
      Guard(team, {.barrier = BarrierMode::on, .limits_to_come = {{BodyId{0}, one}, {BodyId{0}, other}}}),
      std::invalid_argument);
}

TEST(Guard, WhatTheSupervisorSaysBecomesEventsOfTheBody) {
  GuardedFlight flight({.supervisor = SupervisorOptions{}});
  for (int k = 0; k < 5; ++k) flight.step();
  for (int k = 0; k < 30; ++k) flight.step(false);
  ASSERT_EQ(flight.events.size(), 4U);
  EXPECT_EQ(flight.events[0].kind, EventKind::predicted);
  EXPECT_EQ(flight.events[3].kind, EventKind::slowed);
  EXPECT_EQ(flight.events[3].value, 1.0);
  flight.measured.assign(flight.plant.x().begin(), flight.plant.x().end());
  flight.measured[7] = std::nan("");
  flight.stamps.assign(3, flight.t);
  flight.step(false);
  ASSERT_EQ(flight.events.size(), 6U);
  EXPECT_EQ(flight.events[4].kind, EventKind::measurement_not_finite);
  EXPECT_EQ(flight.events[4].value, 1.0);
  EXPECT_EQ(flight.events[5].kind, EventKind::valid) << "of the other, which is seen again";
  EXPECT_EQ(flight.events[5].value, 0.0);
}

TEST(Guard, TheBarrierKeepsThreeDeviationsOfBothEstimatesMore) {
  const auto nearest = [](double of_a, double of_b) {
    GuardedFlight flight({.barrier = BarrierMode::on, .bodies = {{.d_hard = 0.8}, {.d_hard = 0.8}, {}}});
    flight.sigmas = {of_a, of_b, 0.0};
    for (int k = 0; k < 800; ++k) flight.step();
    return flight.nearest;
  };
  const double measured = nearest(0.0, 0.0);
  EXPECT_NEAR(nearest(0.1, 0.0) - measured, 0.3, 0.02);
  EXPECT_NEAR(nearest(0.0, 0.1) - measured, 0.3, 0.02);
  EXPECT_NEAR(nearest(0.1, 0.2) - measured, 3 * std::hypot(0.1, 0.2), 0.03);
  EXPECT_NEAR(nearest(0.9, 0.0) - nearest(Guard::sigma_most, 0.0), 0.0, 1e-9) << "it might be anywhere";
}

TEST(Guard, ARobotWithoutAPositionKeepsNobodyAwayAndIsAskedForNoPlan) {
  for (const bool supervised : {false, true}) {
    GuardOptions options{.barrier = BarrierMode::on};
    if (supervised) options.supervisor = SupervisorOptions{};
    GuardedFlight flight(options, Numbers(8));
    flight.sigmas = {std::numeric_limits<double>::infinity(), 0.0, 0.0};
    for (int k = 0; k < 300; ++k) {
      flight.step();
      ASSERT_FALSE(flight.guard.knows_all());
      ASSERT_FALSE(flight.guard.barriers()[0].active || flight.guard.barriers()[1].active);
    }
    EXPECT_NE(flight.guard.levels()[1], FallbackLevel::land);
    flight.sigmas[0] = 0.05;
    flight.step();
    EXPECT_TRUE(flight.guard.knows_all());
  }
}

TEST(Guard, TheSearchBeginsAndEndsAsEventsAndTheBarrierComesAfterIt) {
  GuardedFlight flight({.barrier = BarrierMode::on,
                        .bodies = {{.d_hard = 3.9}, {.d_hard = 3.9}, {.d_hard = 0.1}},
                        .search = {.predict = 0.5, .back_off = 0.0},
                        .searchers = {BodyId{0}}},
                       Numbers(8));
  View view{
      .robot = BodyId{0}, .target = BodyId{1}, .localized = true, .bearing_sigma = 0.5, .accepted = 0.0};
  flight.views = {&view, 1};
  for (int k = 0; k < 300; ++k) flight.step();
  ASSERT_EQ(flight.events.size(), 1U);
  EXPECT_EQ(flight.events[0].kind, EventKind::search);
  EXPECT_NEAR(flight.events[0].time, 0.5, 0.02);
  EXPECT_EQ(flight.events[0].value, 0.0);
  EXPECT_GT(std::abs(flight.plant.x()[4]), 0.1) << "it sweeps";
  EXPECT_GE(flight.nearest, 3.9);
  view.accepted = view.sighted = flight.t;
  flight.step();
  ASSERT_EQ(flight.events.size(), 2U);
  EXPECT_EQ(flight.events[1].kind, EventKind::found);
}

TEST(Guard, WhereARobotWasNeverSeenTheBarrierStandsBack) {
  GuardedFlight flight({.supervisor = SupervisorOptions{}, .barrier = BarrierMode::on});
  flight.measured.assign(flight.measured.size(), std::nan(""));
  for (int k = 0; k < 50; ++k) {
    flight.stamps.assign(3, flight.t);
    flight.step(false);
    for (const double u : flight.u) ASSERT_NEAR(u, 0.0, 1e-6);
    ASSERT_FALSE(flight.guard.knows_all());
  }
}

// All of a ring are sent into its middle, where nobody gives way to the two that drift through.
TEST(Guard, CommandsAndEventsAreTheSameWhateverTheThreads) {
  constexpr int robots = GuardOptions::shared_from + 5;
  Team team;
  Numbers x0, command;
  for (int i = 0; i < robots; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / robots, c = std::cos(angle), s = std::sin(angle);
    team.add(Multirotor{}, {.name = "uav" + std::to_string(i)});
    x0.insert(x0.end(), {5 * c, 5 * s, 1, -c, -s, 0, 0});
    command.insert(command.end(), {1, 0, 0, 0});
  }
  for (const double side : {-1.0, 1.0}) {
    team.add(Obstacle{.name = side < 0 ? "left" : "right"});
    x0.insert(x0.end(), {3 * side, 0, 1, -side, 0, 0});
  }
  const auto flown = [&](int threads) {
    GuardOptions options{.barrier = BarrierMode::on};
    if (threads > 1) options.pool = std::make_shared<ThreadPool>(threads);
    Guard guard(team, options);
    Plant plant(team, x0);
    Numbers all;
    int active = 0, conflicts = 0;
    for (int k = 0; k < 300; ++k) {
      const double t = 0.01 * k;
      const ValidStates& x = guard.accept_measurement(t, plant.x(), Numbers(at(team.bodies()), t));
      Numbers u = command;
      guard.keep_distances(t, x, Numbers(u.size()), u);
      all.insert(all.end(), u.begin(), u.end());
      for (const BarrierRecord& record : guard.barriers())
        active += record.active, all.push_back(record.reserve);
      for (const Event& event : guard.events()) ++conflicts, all.insert(all.end(), {event.time, event.value});
      EXPECT_TRUE(plant.step(u, 0.01));
    }
    EXPECT_GT(active, 1000);
    EXPECT_GT(conflicts, 0);
    return all;
  };
  const Numbers alone = flown(1);
  for (const int threads : {2, 4}) EXPECT_EQ(flown(threads), alone) << threads << " threads";
}

}  // namespace
}  // namespace sightline
