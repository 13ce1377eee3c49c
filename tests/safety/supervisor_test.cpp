#include "sightline/supervisor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sightline/potentials.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/period.hpp"

namespace sightline {
namespace {

using test::control_period;
using Numbers = std::vector<double>;
using enum FallbackLevel;

// a observes b and target, b stands by itself.
Team team_of_two() {
  Team team;
  const AgentId a = team.add(Multirotor{}, {.name = "a"});
  const AgentId b = team.add(Multirotor{}, {.name = "b"});
  const BodyId target = team.add(Obstacle{.name = "target"});
  team.couple(1.0 * KeepOut{.d_min = 1}, Between{a, b}, felt_by(a));
  team.couple(1.0 * KeepOut{.d_min = 1}, Between{a, target}, felt_by(a));
  return team;
}

Numbers start_of_two() {
  return {0, 0, 1, 1, 0, 0.5, 0.1, /**/ 2, 1, 1.5, 0, 1, 0, 0, /**/ 5, 5, 1, 0.3, 0, 0};
}

// A world that moves as the models say, and a supervisor that sees what the test lets through.
struct World {
  explicit World(const SupervisorOptions& options = {}) : supervisor(team, options) {}

  // One period: bodies that are seen have the stamp of now.
  void step(std::initializer_list<bool> seen = {true, true, true}, double plan_age = 0.0) {
    auto sees = seen.begin();
    for (std::size_t i = 0; i < 3; ++i, ++sees) {
      const std::size_t at = i == 0 ? 0 : i == 1 ? 7 : 14, nx = i == 2 ? 6 : 7;
      if (!*sees) continue;
      std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(at), nx,
                  measured.begin() + static_cast<std::ptrdiff_t>(at));
      stamps[i] = t;
    }
    look(plan_age);
  }
  // One period in which exactly `measured` is there.
  void look(double plan_age = 0.0) {
    const auto states = supervisor.accept_measurement(t, measured, stamps, sigmas);
    estimated.assign(states.begin(), states.end());
    u = requested;
    supervisor.command(t, estimated, Numbers(3, plan_age), added, u);
    for (const Notice& notice : supervisor.notices()) notices.push_back(notice);
    supervisor.record(t, u);
    fly();
  }
  void fly() {
    EXPECT_TRUE(plant.step(u, control_period));
    x.assign(plant.x().begin(), plant.x().end());
    t += control_period;
  }
  void restart() {
    plant = Plant(team, start_of_two());
    x = start_of_two();
  }
  Numbers measured_of_b() const { return {measured.begin() + 7, measured.begin() + 14}; }
  FallbackLevel a() const { return supervisor.level(BodyId{0}); }
  FallbackLevel b() const { return supervisor.level(BodyId{1}); }

  Team team = team_of_two();
  Plant plant{team, start_of_two()};
  Supervisor supervisor;
  Numbers x = start_of_two(), measured = x, stamps = Numbers(3, -infinity);
  Numbers requested = {0.3, -0.2, 0.1, 0.4, -0.5, 0.6, 0.2, -0.7}, u = Numbers(8), added = Numbers(8),
          estimated;
  Numbers sigmas = Numbers(3);
  std::vector<Notice> notices;
  double t = 0.0;
};

TEST(Supervisor, WithGoodDataItIsNotThere) {
  World world;
  for (int k = 0; k < 500; ++k) {
    const Numbers x = world.x;
    world.step();
    ASSERT_EQ(world.estimated, x);
    ASSERT_EQ(world.u, world.requested);
  }
  EXPECT_TRUE(world.notices.empty());
}

TEST(Supervisor, DataOfOneAgeKeepTheRobotOnTheRungOfThatAge) {
  for (const auto& [late, level] : {std::pair{0, valid},
                                    {2, valid},
                                    {3, predicted},
                                    {20, predicted},
                                    {21, slowed},
                                    {50, slowed},
                                    {51, hold},
                                    {200, hold}}) {
    World world;
    std::vector<Numbers> past;
    for (int k = 0; k < 400; ++k) {
      past.push_back(world.x);
      const auto seen = static_cast<std::size_t>(std::max(0, k - late));
      world.measured = past[seen];
      std::fill(world.stamps.begin(), world.stamps.end(), control_period * static_cast<double>(seen));
      world.look();
      if (k >= late) {
        ASSERT_EQ(world.a(), level) << late << " periods late";
        ASSERT_EQ(world.b(), level);
      }
    }
  }
}

TEST(Supervisor, EachRungHasItsCommand) {
  World world;
  world.step();
  for (int k = 0; k < 350; ++k) {
    world.step({false, false, false});
    const Numbers u(world.u.begin(), world.u.begin() + 4),
        requested(world.requested.begin(), world.requested.begin() + 4);
    if (world.a() == valid || world.a() == predicted) {
      ASSERT_EQ(u, requested);
    }
    if (world.a() == slowed) {
      for (std::size_t i = 0; i < 4; ++i) ASSERT_DOUBLE_EQ(u[i], 0.5 * requested[i]);
    }
    if (world.a() == hold || world.a() == land) {
      ASSERT_NE(u, requested);
    }
  }
  EXPECT_EQ(world.a(), land);
  const Sight<double> sight = world.team.model(BodyId{0}).sight(&world.x[0], &world.u[0]);
  EXPECT_LT(norm(sight.v - Vec3<double>{0, 0, -0.3}), 0.01);
}

TEST(Supervisor, WhatIsAddedAfterwardsMovesTheLimitsOfItsCommands) {
  for (const double added : {0.0, 0.6, -0.6}) {
    World world;
    world.added[0] = added;
    world.step();
    // Far too fast forward or backward: it brakes with all there is.
    for (const double speed : {4.0, -4.0}) {
      world.measured[5] = speed;
      Numbers u(8);
      for (int k = 0; k < 60; ++k) {
        world.t += 0.01;
        world.supervisor.accept_measurement(world.t, world.measured, world.stamps);
        Numbers x = world.measured;
        u = world.requested;
        world.supervisor.command(world.t, x, Numbers(3, 1.0), world.added, u);
      }
      ASSERT_EQ(world.a(), hold);
      EXPECT_NEAR(u[0] + added, speed > 0 ? -1.0 : 1.0, 1e-12);
    }
  }
}

TEST(Supervisor, ARobotThatHoldsComesToRestAndStays) {
  World world;
  for (int k = 0; k < 5; ++k) world.step();
  for (int k = 0; k < 195; ++k) world.step({false, true, true});
  ASSERT_EQ(world.a(), hold);
  EXPECT_EQ(world.b(), valid);
  const Sight<double> sight = world.team.model(BodyId{0}).sight(&world.x[0], &world.u[0]);
  EXPECT_LT(norm(sight.v), 0.05);
}

TEST(Supervisor, ARobotThatLandsEndsOnTheGroundAndStaysThere) {
  for (const double ground : {0.0, -2.0}) {
    World world({.ground = ground});
    for (int k = 0; k < 5; ++k) world.step();
    while (world.a() != grounded && world.t < 30) world.step({false, false, false});
    ASSERT_EQ(world.a(), grounded);
    EXPECT_NEAR(world.x[2], ground, 0.03);
    for (int k = 0; k < 500; ++k) world.step();
    EXPECT_EQ(world.a(), grounded) << "good data do not wake it";
    EXPECT_NEAR(world.x[2], ground, 0.03);
    EXPECT_LT(std::hypot(world.x[5], world.x[6]), 1e-3);
  }
}

TEST(Supervisor, AnOldPartnerMakesTheRobotHoldThatFeelsItAndNoOther) {
  for (const bool target : {false, true}) {
    World world;
    for (int k = 0; k < 5; ++k) world.step();
    for (int k = 0; k < 400; ++k) world.step({true, target, !target});
    EXPECT_EQ(world.a(), hold);
    EXPECT_EQ(world.b(), target ? valid : land) << "b feels nothing, and lands when it is blind itself";
    for (int k = 0; k < 5; ++k) world.step();
    EXPECT_EQ(world.a(), valid) << "comes back with the data";
  }
}

TEST(Supervisor, AnOldPlanTakesTheSameRungs) {
  for (const auto& [age, level] :
       {std::pair{0.01, valid}, {0.1, predicted}, {0.3, slowed}, {0.9, hold}, {2.5, land}}) {
    World world;
    world.step();
    world.step({true, true, true}, age);
    EXPECT_EQ(world.a(), level) << age;
  }
}

TEST(Supervisor, EachTransitionAndEachBeginningFaultIsToldOnce) {
  World world;
  for (int k = 0; k < 5; ++k) world.step();
  for (int k = 0; k < 60; ++k) {
    std::copy(world.x.begin(), world.x.end(), world.measured.begin());
    std::fill(world.stamps.begin(), world.stamps.end(), world.t);
    world.measured[7] = std::nan("");
    world.look();
  }
  for (int k = 0; k < 5; ++k) world.step();
  std::vector<std::pair<int, std::string_view>> reported;
  for (const Notice& notice : world.notices) {
    const auto* level = std::get_if<FallbackLevel>(&notice.what);
    reported.emplace_back(notice.body.index, level != nullptr
                                                 ? to_string(*level)
                                                 : to_string(std::get<MeasurementFault>(notice.what)));
  }
  const std::vector<std::pair<int, std::string_view>> expected = {
      {1, "not_finite"}, {0, "predicted"}, {1, "predicted"}, {0, "slowed"}, {1, "slowed"},
      {0, "hold"},       {1, "hold"},      {0, "valid"},     {1, "valid"}};
  EXPECT_EQ(reported, expected);
}

TEST(Supervisor, BeforeARobotWasEverSeenItIsToldToStandStillAndNeverToLand) {
  World world;
  world.measured.assign(world.measured.size(), std::nan(""));
  for (int k = 0; k < 500; ++k) {
    std::fill(world.stamps.begin(), world.stamps.end(), world.t);
    world.look();
    ASSERT_EQ(world.a(), hold);
    ASSERT_FALSE(world.supervisor.knows_all());
    ASSERT_TRUE(all_finite(world.estimated));
    for (const double u : world.u) ASSERT_NEAR(u, 0.0, 1e-6);
  }
  for (int k = 0; k < 5; ++k) world.step();
  EXPECT_EQ(world.a(), valid);
  EXPECT_TRUE(world.supervisor.knows_all());
}

// One whose position is estimated, with this deviation, at each period.
struct Estimated : World {
  void estimate(double sigma, int periods = 1, double jump = 0.0) {
    for (int k = 0; k < periods; ++k) {
      std::copy(x.begin(), x.end(), measured.begin());
      measured[0] += jump;
      std::fill(stamps.begin(), stamps.end(), t);
      sigmas[0] = sigma;
      if (std::isinf(sigma)) stamps[0] = -infinity;
      look(plan_age);
    }
  }
  double plan_age = 0.0;
};

TEST(Supervisor, TheDeviationOfAnEstimateDecidesBesideItsAge) {
  Estimated world;
  world.estimate(0.9, 20);
  EXPECT_EQ(world.a(), valid);
  world.estimate(1.1);
  EXPECT_EQ(world.a(), hold);
  world.estimate(0.9);
  EXPECT_EQ(world.a(), valid);
  world.stamps[0] = 0.0;  // nobody tells its motion any more
  for (int k = 0; k < 30; ++k) world.look();
  EXPECT_EQ(world.a(), slowed);
  world.estimate(2.1);
  EXPECT_EQ(world.a(), land);
  world.estimate(0.1);
  EXPECT_EQ(world.a(), land) << "it goes on landing";
}

TEST(Supervisor, AnEstimateMayJumpButMustBeANumber) {
  Estimated world;
  world.estimate(0.5, 20);
  world.estimate(0.1, 1, 0.9);
  EXPECT_TRUE(world.notices.empty());
  EXPECT_TRUE(world.supervisor.trusts(BodyId{0}));
  world.estimate(0.1, 1, std::nan(""));
  EXPECT_FALSE(world.supervisor.trusts(BodyId{0}));
  ASSERT_FALSE(world.notices.empty());
  EXPECT_EQ(std::get<MeasurementFault>(world.notices[0].what), MeasurementFault::not_finite);
}

TEST(Supervisor, WhileARobotFindsOutWhereItIsAllHoldAndNobodyLands) {
  Estimated world;
  for (int k = 0; k < 1000; ++k) {
    world.plan_age = 0.01 * k;  // nobody is asked
    world.estimate(infinity);
    ASSERT_TRUE(world.supervisor.awaits_position());
    ASSERT_FALSE(world.supervisor.knows_all());
    ASSERT_EQ(world.a(), hold);
    ASSERT_LE(world.b(), hold);
  }
  EXPECT_EQ(world.b(), hold);
  world.plan_age = 0.0;
  world.estimate(0.1);
  EXPECT_FALSE(world.supervisor.awaits_position());
  EXPECT_EQ(world.a(), valid);
  EXPECT_EQ(world.b(), valid);
  // What knew where it was and no longer does grows old.
  world.estimate(infinity, 100);
  EXPECT_EQ(world.a(), hold);
  EXPECT_FALSE(world.supervisor.awaits_position());
  world.estimate(infinity, 150);
  EXPECT_EQ(world.a(), land);
}

TEST(Supervisor, OneThatComesWithoutAPositionHoldsUntilItHasOneAndTheOthersFly) {
  Estimated world;
  Membership now = ActiveTeam(world.team).membership();
  world.estimate(0.1, 10);
  now.presence[0] = Presence::absent;
  world.supervisor.follow(now, world.t, world.x);
  world.estimate(infinity, 10);
  now.presence[0] = Presence::steered;
  world.supervisor.follow(now, world.t, world.x);
  world.estimate(infinity, 400);
  EXPECT_EQ(world.a(), hold);
  EXPECT_EQ(world.b(), valid);
  world.estimate(0.1);
  EXPECT_EQ(world.a(), valid);
}

TEST(Supervisor, OneWithoutAPositionIsBrakedByTheVelocityThatItIsTold) {
  Estimated world;
  world.estimate(infinity);
  EXPECT_LT(world.u[0], -0.1) << "it drifts ahead";
}

TEST(Supervisor, APartnerWhoseEstimateIsBadMakesARobotHold) {
  Estimated world;
  world.sigmas[1] = 3.0;
  world.estimate(0.1);
  EXPECT_EQ(world.a(), hold);
  EXPECT_EQ(world.b(), land);
}

TEST(Supervisor, WhateverIsAskedAndMeasuredTheCommandIsFiniteAndWithinItsLimits) {
  RandomStream chance(11, StreamId::gust, 0);
  const double bad[] = {NAN, infinity, -infinity, 1e300, -1e300, 5e-324, -0.0, 2.0, 1e9};
  const auto pick = [&] { return bad[static_cast<std::size_t>(chance.uniform() * 8.999)]; };
  World world;
  for (int k = 0; k < 20'000; ++k) {
    if (k % 400 == 0) {
      std::destroy_at(&world.supervisor);
      std::construct_at(&world.supervisor, world.team, SupervisorOptions{});
      world.restart();
    }
    std::copy(world.x.begin(), world.x.end(), world.measured.begin());
    for (double& stamp : world.stamps) stamp = chance.uniform() < 0.1 ? pick() : world.t;
    if (chance.uniform() < 0.5) world.measured[static_cast<std::size_t>(chance.uniform() * 19.99)] = pick();
    for (double& requested : world.requested)
      requested = chance.uniform() < 0.1 ? pick() : 2.0 * chance.uniform() - 1.0;
    world.look(chance.uniform() < 0.05 ? pick() : 0.0);
    ASSERT_TRUE(all_finite(world.estimated));
    for (const double u : world.u) ASSERT_LE(std::abs(u), 1.0);
  }
}

TEST(Supervisor, RefusesOptionsOutOfTheirRangeByName) {
  const auto refusal = [](const SupervisorOptions& options) -> std::string {
    try {
      Supervisor(team_of_two(), options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal({.times = {.slow_after = 0.01}}), "supervisor.slow_after = 0.01, expected >= fresh");
  EXPECT_EQ(refusal({.times = {.hold_after = 0.1}}), "supervisor.hold_after = 0.1, expected >= slow_after");
  EXPECT_THAT(refusal({.times = {.land_after = 0.1}}), testing::StartsWith("supervisor.land_after = 0.1"));
  EXPECT_EQ(refusal({.slow_factor = 1.5}), "supervisor.slow_factor = 1.5, expected 0 to 1");
  EXPECT_EQ(refusal({.sigmas = {.hold = 0.0}}), "supervisor.sigma_hold = 0, expected > 0 m");
  EXPECT_EQ(refusal({.sigmas = {.hold = 2.0}}), "supervisor.sigma_land = 2, expected > sigma_hold");
  EXPECT_EQ(refusal({.limits = {.accept_after = 0}}), "supervisor.accept_after = 0, expected 1 to 1000");
  EXPECT_EQ(refusal({}), "accepted");
}

TEST(Supervisor, OfABodyThatIsAbsentNothingIsJudgedAndOneThatComesBeginsAnew) {
  for (const bool blind : {false, true}) {  // whether measurements of it come while it is absent
    World world;
    Membership now = ActiveTeam(world.team).membership();
    now.presence[1] = Presence::absent;
    now.partners[0] = {BodyId{2}};
    world.supervisor.follow(now, 0.0, world.x);
    for (int k = 0; k < 500; ++k) world.step({true, !blind, true});
    EXPECT_TRUE(world.notices.empty());
    EXPECT_EQ(world.a(), valid);
    Membership then = now;
    then.presence[1] = Presence::steered;
    then.partners[0] = {BodyId{1}, BodyId{2}};
    world.supervisor.follow(then, world.t, world.x);
    world.step();
    EXPECT_EQ(world.b(), valid);
    EXPECT_EQ(Numbers(world.estimated.begin() + 7, world.estimated.begin() + 14), world.measured_of_b());
    EXPECT_TRUE(world.supervisor.knows_all());
    // Without data it grows old from its coming on.
    for (int k = 0; k < 40; ++k) world.step({true, false, true});
    EXPECT_EQ(world.b(), slowed);
    EXPECT_EQ(world.a(), slowed) << "its partner";
    for (int k = 0; k < 40; ++k) world.step({true, false, true});
    EXPECT_EQ(world.b(), hold);
  }
}

TEST(Supervisor, WhoLandedAndWasTakenAwayFliesWhenItIsAddedAgain) {
  World world;
  Membership now = ActiveTeam(world.team).membership();
  for (int k = 0; k < 250; ++k) world.step({true, k == 0, true});
  ASSERT_EQ(world.b(), land);
  now.presence[1] = Presence::absent;
  world.supervisor.follow(now, world.t, world.x);
  world.step();
  now.presence[1] = Presence::steered;
  world.supervisor.follow(now, world.t, world.x);
  world.step();
  EXPECT_EQ(world.b(), valid);
}

TEST(Supervisor, WhatWasMeasuredBeforeABodyCameIsNotOfIt) {
  World world;
  Membership now = ActiveTeam(world.team).membership();
  now.presence[1] = Presence::absent;
  world.supervisor.follow(now, 0.0, world.x);
  for (int k = 0; k < 50; ++k) world.step();
  now.presence[1] = Presence::steered;
  Numbers there = world.x;
  there[7] += 30.0;
  world.supervisor.follow(now, world.t, there);
  world.stamps[1] = world.t - 0.1;
  world.look();
  EXPECT_EQ(world.estimated[7], there[7]);
  EXPECT_EQ(world.b(), valid);
}

TEST(Supervisor, ThePartnersThatCountAreThoseOfTheTeamThereIs) {
  World world;
  Membership now = ActiveTeam(world.team).membership();
  now.partners[0] = {BodyId{1}};
  world.supervisor.follow(now, 0.0, world.x);
  for (int k = 0; k < 100; ++k) world.step({true, true, k == 0});
  EXPECT_EQ(world.a(), valid) << "it feels the target no more";
  now.partners[0] = {BodyId{1}, BodyId{2}};
  world.supervisor.follow(now, world.t, world.x);
  world.step({true, true, false});
  EXPECT_EQ(world.a(), hold);
}

}  // namespace
}  // namespace sightline
