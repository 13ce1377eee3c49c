#include "sightline/judge/drift.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Path = std::function<Vec3<double>(double)>;
using Weights = std::array<double, 7>;
using Found = std::vector<Drift::Found>;

constexpr double settle = 2.0;

Vec3<double> rests(double) { return {1, 2, 3}; }
Vec3<double> climbs(double t) { return {0, 0, 1 + t}; }
Vec3<double> circles(double t) { return {std::cos(0.3 * t), std::sin(0.3 * t), 1}; }

// Two robots that are free, unless their Q says other, and a body that nobody controls.
struct PairAndPost {
  Team team;
  AgentId a, b;
  BodyId post;

  explicit PairAndPost(const Weights& Q_a = {}, const Reference& x_ref = {}, const Weights& Q_b = {})
      : a(team.add(Multirotor{}, {.Q = Q_a, .x_ref = x_ref})),
        b(team.add(Multirotor{}, {.Q = Q_b})),
        post(team.add(Obstacle{"post"})) {}

  void follow(AgentId who, BodyId whom) {
    team.couple(1.0 * Cohesion{.d_max = 2.0}, Between{who, whom}, felt_by(who));
  }
  // Of the robots a and b and the post on their paths.
  std::optional<Found> flown(const Path& of_a, const Path& of_b, const Path& of_post = rests,
                             double duration = 30.0, Presence of_robots = Presence::steered) const {
    Drift drift(team, settle);
    const std::vector<Presence> presence = {of_robots, of_robots, Presence::hold};
    std::vector<const Agent*> agents(3);
    if (of_robots == Presence::steered) agents = {&team.agent(a), &team.agent(b), nullptr};
    for (int k = 0; 0.01 * k < duration; ++k) {
      const double t = 0.01 * k;
      if (!drift.due(t)) continue;
      std::vector<Sight<double>> sights(3);
      sights[0].p = of_a(t), sights[1].p = of_b(t), sights[2].p = of_post(t);
      drift.mark(t, sights, presence, agents);
    }
    return drift.found();
  }
};

constexpr Weights requested = {1, 1, 1, 0, 0, 0, 0};

TEST(Drift, TwoThatObserveEachOtherAndClimbForEverAreTold) {
  PairAndPost flight;
  flight.follow(flight.a, flight.b);
  flight.follow(flight.b, flight.a);
  const auto found = flight.flown(climbs, [](double t) { return climbs(t) + Vec3<double>{1, 0, 0.2}; });
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 2U);
  for (const Drift::Found& drift : *found) {
    EXPECT_NEAR(norm(drift.v - Vec3<double>{0, 0, 1}), 0.0, 1e-9);
    EXPECT_FALSE(drift.from_reference);
  }
}

TEST(Drift, AnyDirectionAndSpeedAboveTwoCentimetresASecondIsTold) {
  Random random(1);
  for (int n = 0; n < 100; ++n) {
    const Vec3<double> v =
        uniform(random, 0.03, 2.0) * Vec3<double>{std::cos(n), std::sin(n), uniform(random, -1, 1)};
    const auto found = PairAndPost().flown([&](double t) { return t * v; }, rests);
    ASSERT_EQ(found->size(), 1U);
    EXPECT_NEAR(norm((*found)[0].v - v), 0.0, 1e-9);
  }
  EXPECT_TRUE(PairAndPost().flown([](double t) { return Vec3<double>{0.01 * t, 0, 0}; }, rests)->empty());
}

TEST(Drift, OneThatLeavesItsReferenceIsToldWhateverItFollows) {
  PairAndPost flight(requested, Circle{.centre = {0, 0, 1}, .radius = 1.0, .rate = 0.3});
  flight.follow(flight.a, flight.b);
  const auto found = flight.flown(climbs, climbs);
  ASSERT_EQ(found->size(), 2U);
  EXPECT_TRUE((*found)[0].from_reference);
  EXPECT_FALSE((*found)[1].from_reference);
}

TEST(Drift, AReferenceThatMovesMayBeFollowed) {
  const Path line = [](double t) { return Vec3<double>{0.8 * t, -0.3 * t, 1}; };
  const Reference along([](double t) { return Pose<double>{{0.8 * t, -0.3 * t, 1}, {1, 0}}; });
  for (const double lag : {0.0, 0.5, 2.0}) {
    EXPECT_TRUE(PairAndPost(requested, along).flown([&](double t) { return line(t - lag); }, rests)->empty())
        << lag;
    EXPECT_TRUE(PairAndPost(requested, Circle{.centre = {0, 0, 1}, .radius = 1.0, .rate = 0.3})
                    .flown([&](double t) { return circles(t - lag); }, rests)
                    ->empty())
        << lag;
  }
  EXPECT_FALSE(PairAndPost(requested, along).flown([&](double t) { return line(-t); }, rests)->empty());
}

TEST(Drift, OneThatIsOnItsWayOrLeftBehindDoesNotDrift) {
  const Path comes = [](double t) { return Vec3<double>{40 - t, 0, 1}; };
  EXPECT_TRUE(PairAndPost(requested).flown(comes, rests)->empty());
  const Reference fast([](double t) { return Pose<double>{{2 * t, 0, 0}, {1, 0}}; });
  EXPECT_TRUE(PairAndPost(requested, fast)
                  .flown(
                      [](double t) {
                        return Vec3<double>{t, 0, 0};
                      },
                      rests)
                  ->empty());
}

TEST(Drift, OneThatFollowsWhatMovesDoesNotNorDoThoseBehindIt) {
  PairAndPost flight;
  flight.follow(flight.a, flight.post);
  flight.follow(flight.b, flight.a);
  const Path ahead = [](double t) { return climbs(t) + Vec3<double>{0, 0, 1}; };
  EXPECT_TRUE(flight.flown(climbs, climbs, ahead)->empty());
  EXPECT_EQ(flight.flown(climbs, climbs, rests)->size(), 2U);
  EXPECT_TRUE(flight.flown(rests, rests, ahead)->empty());

  // Those ahead are asked to move.
  PairAndPost led(requested, Reference([](double t) { return Pose<double>{{0, 0, 1 + t}, {1, 0}}; }));
  led.follow(led.b, led.a);
  EXPECT_TRUE(led.flown(climbs, climbs)->empty());
  PairAndPost rated({0, 0, 0, 0, 0, 1, 1},
                    Reference([](double) { return std::array<double, 7>{0, 0, 0, 0, 0, 0.5, 0}; }));
  rated.follow(rated.b, rated.a);
  const Path forth = [](double t) { return Vec3<double>{0.5 * t, 0, 1}; };
  EXPECT_TRUE(rated.flown(forth, forth)->empty());
}

TEST(Drift, AHeightThatIsAskedForHoldsTheHeightAlone) {
  constexpr Weights height = {0, 0, 1, 0, 0, 0, 0};
  const Reference up([](double t) { return Pose<double>{{0, 0, 1 + t}, {1, 0}}; });
  EXPECT_TRUE(PairAndPost(height, up).flown(climbs, rests)->empty());
  EXPECT_EQ(PairAndPost(height).flown(climbs, rests)->size(), 1U);
  EXPECT_EQ(PairAndPost(height).flown([](double t) { return Vec3<double>{t, 0, 0}; }, rests)->size(), 1U);
}

TEST(Drift, WhatSwingsOrComesToRestDoesNotDrift) {
  PairAndPost flight;
  flight.follow(flight.a, flight.post);
  EXPECT_TRUE(flight.flown([](double t) { return Vec3<double>{0, std::sin(0.3 * t), 1}; }, rests)->empty());
  EXPECT_TRUE(flight.flown(
                        [](double t) {
                          return Vec3<double>{5 * std::exp(-t / 5), 0, 1};
                        },
                        rests)
                  ->empty());
  EXPECT_TRUE(flight.flown(
                        [](double t) {
                          return Vec3<double>{-5 * std::exp(-t / 5), 0, 1};
                        },
                        rests)
                  ->empty());
  EXPECT_TRUE(flight.flown(rests, rests, circles)->empty());
}

TEST(Drift, OnlyRobotsThatAreSteeredAreJudged) {
  for (const Presence presence : {Presence::absent, Presence::hold, Presence::land})
    EXPECT_TRUE(PairAndPost().flown(climbs, climbs, rests, 30.0, presence)->empty());
}

TEST(Drift, OneThatLandsIsNotJudgedFromThenOn) {
  for (const bool lands : {false, true}) {
    Scenario scenario;
    scenario.team = PairAndPost().team;
    const PresentTeam present(scenario);
    Drift drift(scenario.team, 0.0);
    Sample sample;
    sample.presence = {Presence::steered, Presence::steered, Presence::hold};
    std::vector<Sight<double>> sights(3);
    for (int k = 0; k < 1000; ++k) {
      sample.time = 0.01 * k;
      sample.of = k == 1 ? Sample::Of::states : Sample::Of::update;
      sample.event_count = lands && k == 1 ? 1 : 0;
      sample.events[0] = {sample.time, EventKind::land, 0, 0.0};
      sights[0].p = climbs(sample.time);
      drift.add(sample, sights, present);
    }
    ASSERT_TRUE(drift.found());
    EXPECT_EQ(drift.found()->size(), lands ? 0U : 1U);
  }
}

TEST(Drift, FiveSecondsAfterSettleAreNeeded) {
  EXPECT_FALSE(PairAndPost().flown(climbs, rests, rests, settle + 5.0));
  EXPECT_TRUE(PairAndPost().flown(climbs, rests, rests, settle + 5.01));
}

TEST(Drift, AnotherTeamBeginsAnew) {
  const PairAndPost flight;
  Drift drift(flight.team, 0.0);
  const std::vector<Sight<double>> sights(3);
  const std::vector<Presence> presence(3, Presence::hold);
  const std::vector<const Agent*> agents(3);
  for (int second = 0; second < 6; ++second) drift.mark(second, sights, presence, agents);
  EXPECT_TRUE(drift.found());
  drift.restart({});
  EXPECT_FALSE(drift.found());
  EXPECT_TRUE(drift.due(5.5));
}

}  // namespace
}  // namespace sightline
