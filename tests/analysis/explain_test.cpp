#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/analysis.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

struct TwoRobots {
  Team team;
  AgentId a = team.add(Multirotor{}), b = team.add(Multirotor{});
};

TEST(Explain, ThePapersPairRestsWhereReliabilityFoundIt) {
  const Team team = paper::team(paper::Variant::masked);
  const Explanation e = explain(team);
  ASSERT_EQ(e.pairs.size(), 1u);
  const PairAdvice& pair = e.pairs[0];
  ASSERT_TRUE(pair.rest && pair.holds.size() == 1);
  EXPECT_NEAR(pair.rest->distance, 1.694, 1e-3);
  EXPECT_NEAR(pair.rest->across, 1.517, 1e-3);
  EXPECT_NEAR(pair.rest->height, 0.755, 1e-3);
  EXPECT_NEAR(pair.rest->cost, 0.14, 5e-3);
  EXPECT_NEAR(pair.rest->within.low, 1.60, 0.01);
  EXPECT_NEAR(pair.rest->within.high, 1.77, 0.01);
  EXPECT_TRUE(pair.rest->broken.empty());
  EXPECT_NEAR(pair.holds.at(0).low, 1.0, 1e-3);
  EXPECT_NEAR(pair.holds.at(0).high, 2.0, 1e-3);
  EXPECT_EQ(pair.limits[0].kind, LimitKind::view);
  EXPECT_EQ(pair.limits[1].kind, LimitKind::together);
  EXPECT_EQ(pair.limits[2].kind, LimitKind::apart);
  EXPECT_THAT(to_string(e, team), HasSubstr("D = 1.694 m"));
}

TEST(Explain, DistanceLimitsHoldTogetherIfAndOnlyIfTheyLeaveABand) {
  Random random(1);
  for (int n = 0; n < 30; ++n) {
    const double d_min = uniform(random, 0.2, 5), d_max = uniform(random, 0.2, 5);
    if (std::fabs(d_max - d_min) < 0.3) continue;
    TwoRobots two;
    two.team.couple(1.0 * KeepOut{.d_min = d_min}, Between{two.a, two.b});
    two.team.couple(1.0 * Cohesion{.d_max = d_max}, Between{two.b, two.a});
    const Explanation e = explain(two.team);
    ASSERT_EQ(e.pairs.size(), 1u);
    const PairAdvice& pair = e.pairs[0];
    EXPECT_EQ(pair.holds.empty(), d_min >= d_max);
    const std::string words = to_string(e, two.team);
    if (!pair.holds.empty()) {
      EXPECT_NEAR(pair.holds.at(0).low, d_min, 1e-4);
      EXPECT_NEAR(pair.holds.at(0).high, d_max, 1e-4);
      EXPECT_THAT(words, Not(HasSubstr("contradiction")));
    } else {
      EXPECT_THAT(pair.contradictions, testing::ElementsAre(std::pair<std::size_t, std::size_t>{0, 1}));
      EXPECT_THAT(words, HasSubstr("couple[0] keep_out and couple[1] cohesion cannot hold at once"));
    }
  }
}

TEST(Explain, AConeAndALimitOnTheHeightThatExcludeEachOtherAreNamed) {
  TwoRobots two;
  two.team.couple(1.0 * SensorCone{.alpha = 0.3, .mount = {.pitch = 0.8}}, Between{two.a, two.b});
  two.team.couple(1.0 * Region("r_z > 0.5 m"), Between{two.a, two.b});
  const Explanation e = explain(two.team);
  EXPECT_TRUE(e.pairs[0].holds.empty());
  EXPECT_EQ(e.pairs[0].contradictions.size(), 1u);
}

TEST(Explain, WhatAPotentialCostsAtWorstIsItsWeightTimesItsHeight) {
  TwoRobots two;
  two.team.couple(0.5 * KeepOut{.kappa_H = 3.0, .kappa_G = 0.0, .kappa_A = 50.0}, Between{two.a, two.b});
  two.team.couple(0.5 * Cohesion{.kappa_H = 2.0, .kappa_G = 0.1, .kappa_A = 50.0}, Between{two.a, two.b});
  const Explanation e = explain(two.team);
  EXPECT_NEAR(e.pairs[0].limits[0].worst, 1.5, 1e-6);
  EXPECT_NEAR(e.pairs[0].limits[1].worst, 0.5 * (2.0 + 0.1 * 36), 1e-6);
}

/// Section 7.3: a robot that looks at a target and is to keep clear of an obstacle.
Team obstacle_team(double weight) {
  Team team;
  const AgentId robot = team.add(Multirotor{});
  const BodyId target = team.add(Obstacle{"target"}), obstacle = team.add(Obstacle{"obstacle"});
  team.couple(0.4 * SensorCone{}, Between{robot, target});
  team.couple(0.4 * Cohesion{.kappa_G = 1e-4}, Between{robot, target});
  team.couple(0.4 * KeepOut{.d_min = 0.7, .kappa_G = 1e-4}, Between{robot, target});
  team.couple(weight * KeepOut{.kappa_H = 1.5}, Between{robot, obstacle});
  return team;
}

TEST(Explain, ARobotThatRatherIsHitThanLosesItsTargetIsToldWhichWeightToRaise) {
  const Team team = obstacle_team(0.6);
  const Explanation e = explain(team);
  ASSERT_EQ(e.hits.size(), 2u);
  const HitCost& obstacle = e.hits[1];
  EXPECT_FALSE(e.hits[0].weight) << "the target it rather evades";
  EXPECT_EQ(obstacle.coupling, 3u);
  EXPECT_NEAR(obstacle.hit, 0.9, 0.06);
  EXPECT_GE(obstacle.others, 1.0);
  EXPECT_THAT(to_string(e, team), HasSubstr("raise the weight of couple[3] keep_out"));
  ASSERT_TRUE(obstacle.weight);
  const Team heeded = obstacle_team(*obstacle.weight);
  EXPECT_FALSE(explain(heeded).hits[1].weight) << "the weight it was told is enough";
  EXPECT_THAT(to_string(explain(heeded), heeded), HasSubstr("it evades"));
}

TEST(Explain, PairsComeInTheOrderOfTheirFirstCouplingWithAllTheyShare) {
  const Explanation e = explain(obstacle_team(0.6));
  ASSERT_EQ(e.pairs.size(), 2u);
  EXPECT_EQ(e.pairs[0].limits.size(), 3u);
  EXPECT_EQ(e.pairs[1].limits.size(), 1u);
  EXPECT_FALSE(e.pairs[1].rest) << "a keep-out alone holds nobody anywhere";
}

TEST(Explain, TwoRobotsThatLookAtEachOtherRestFaceToFace) {
  TwoRobots two;
  const SensorMount level = {0.0, 0.0};
  for (const Between between : {Between{two.a, two.b}, Between{two.b, two.a}}) {
    two.team.couple(1.0 * SensorCone{.mount = level}, between);
  }
  two.team.couple(1.0 * KeepOut{}, Between{two.a, two.b});
  two.team.couple(1.0 * Cohesion{}, Between{two.a, two.b});
  const Explanation e = explain(two.team);
  ASSERT_TRUE(e.pairs[0].rest);
  EXPECT_NEAR(e.pairs[0].rest->height, 0.0, 1e-3);
  EXPECT_TRUE(e.pairs[0].rest->broken.empty());
}

TEST(Explain, OfWhatDifferentRobotsFeelTheCostsAreNotAdded) {
  // Each wants to be above the other: the sum of both costs has a least, and nobody goes there.
  TwoRobots two;
  for (const auto& [a, b] : {std::pair(two.a, two.b), std::pair(two.b, two.a)}) {
    two.team.couple(4.0 * Bearing{.mount = {.pitch = 0.3, .offset = 0.1}}, Between{a, b}, felt_by(a));
    two.team.couple(4.0 * TooNear{.d_min = 1.0}, Between{a, b}, felt_by(a));
    two.team.couple(4.0 * TooFar{.d_max = 2.0}, Between{a, b}, felt_by(a));
  }
  const Explanation e = explain(two.team);
  EXPECT_FALSE(e.pairs[0].rest);
  ASSERT_TRUE(e.pairs[0].drift);
  EXPECT_GT(e.pairs[0].drift->z, 0.0);
  EXPECT_THAT(to_string(e, two.team), HasSubstr("by what each feels they climb together for ever"));
}

TEST(Explain, WhereEachFeelsItsOwnAndBothAgreeTheyRest) {
  TwoRobots two;
  two.team.couple(1.0 * TooNear{.d_min = 1.5}, Between{two.a, two.b}, felt_by(two.a));
  two.team.couple(1.0 * TooFar{.d_max = 1.6}, Between{two.a, two.b}, felt_by(two.a));
  two.team.couple(1.0 * TooNear{.d_min = 1.5}, Between{two.b, two.a}, felt_by(two.b));
  two.team.couple(1.0 * TooFar{.d_max = 1.6}, Between{two.b, two.a}, felt_by(two.b));
  const Explanation e = explain(two.team);
  ASSERT_TRUE(e.pairs[0].rest);
  EXPECT_NEAR(e.pairs[0].rest->distance, 1.55, 0.02);
}

TEST(Explain, ALimitInTheGlobalFrameIsLookedAtAroundTheStarts) {
  TwoRobots two;
  two.team.couple(1.0 * Region("target.p_x < -8 m").slope(Softplus{}), Between{two.a, two.b}, felt_by(two.b));
  const std::vector<double> there = {-10, 0, 1, 1, 0, 0, 0, -9, 0, 1, 1, 0, 0, 0},
                            far_off = {20, 0, 1, 1, 0, 0, 0, 21, 0, 1, 1, 0, 0, 0};
  const LimitWorth here = explain(two.team, there).pairs[0].limits[0];
  EXPECT_TRUE(here.in_world);
  ASSERT_EQ(here.holds.size(), 1u);
  EXPECT_EQ(here.holds[0].low, 0.0);
  const LimitWorth beyond = explain(two.team, far_off).pairs[0].limits[0];
  ASSERT_EQ(beyond.holds.size(), 1u);
  EXPECT_NEAR(beyond.holds[0].low, 28.0, 1.0);
  EXPECT_THAT(to_string(explain(two.team, there), two.team), HasSubstr("it depends on where in G they are"));
}

TEST(Explain, ARegionOfTwoWindowsHasTwoBands) {
  TwoRobots two;
  two.team.couple(1.0 * Region(any_of({"1 m < distance < 2 m", "4 m < distance < 5 m"})),
                  Between{two.a, two.b});
  const std::vector<DistanceBand> holds = explain(two.team).pairs[0].limits[0].holds;
  ASSERT_EQ(holds.size(), 2u);
  EXPECT_NEAR(holds[0].low, 1.0, 1e-4);
  EXPECT_NEAR(holds[0].high, 2.0, 1e-4);
  EXPECT_NEAR(holds[1].low, 4.0, 1e-4);
  EXPECT_NEAR(holds[1].high, 5.0, 1e-4);
}

TEST(Explain, EvadingAPartnerCostsNothingWhereItsOtherLimitsHoldToo) {
  TwoRobots two;
  two.team.couple(4.0 * TooNear{.d_min = 1.0}, Between{two.a, two.b});
  two.team.couple(4.0 * TooFar{.d_max = 2.0}, Between{two.a, two.b});
  for (const HitCost& hit : explain(two.team).hits) EXPECT_FALSE(hit.weight);
}

TEST(Explain, ALimitOnAVelocityIsNoPlaceToRest) {
  TwoRobots two;
  two.team.couple(1.0 * Region("target.v_x < 0.5 m/s").slope(Softplus{}), Between{two.a, two.b});
  EXPECT_FALSE(explain(two.team).pairs[0].rest);
}

TEST(Explain, ALimitOnTheRangeOfASensorKeepsTogether) {
  TwoRobots two;
  two.team.couple(1.0 * Region("range < 8 m").slope(Softplus{}).seen_from({}), Between{two.a, two.b});
  EXPECT_EQ(explain(two.team).pairs[0].limits[0].kind, LimitKind::together);
}

TEST(Explain, AFormulaThatIsNoNumberSomewhereHoldsNothingUp) {
  TwoRobots two;
  two.team.couple(1.0 * Region("sqrt(x * 1 m) < 1 m").slope(Softplus{}), Between{two.a, two.b});
  EXPECT_FALSE(explain(two.team).pairs[0].holds.empty());
}

TEST(Explain, PairsThatAreAlikeAreExplainedOnce) {
  Team team;
  std::vector<AgentId> robots;
  for (int i = 0; i < 5; ++i) robots.push_back(team.add(Multirotor{}));
  for (std::size_t i = 1; i < 5; ++i) {
    team.couple(1.0 * KeepOut{.d_min = i == 3 ? 3.0 : 1.5}, Between{robots[0], robots[i]});
    team.couple(1.0 * Cohesion{.d_max = 1.0}, Between{robots[i], robots[0]});
  }
  const Explanation e = explain(team);
  ASSERT_EQ(e.pairs.size(), 4u);
  EXPECT_FALSE(e.pairs[0].same_as);
  EXPECT_EQ(e.pairs[1].same_as, 0u);
  EXPECT_FALSE(e.pairs[2].same_as) << "another number";
  EXPECT_EQ(e.pairs[3].same_as, 0u);
  EXPECT_EQ(e.pairs[3].second, robots[4]);
  EXPECT_THAT(e.pairs[3].contradictions, testing::ElementsAre(std::pair<std::size_t, std::size_t>{6, 7}));
  EXPECT_THAT(to_string(e, team), HasSubstr("uav0 and uav4: as uav0 and uav1"));
}

TEST(Explain, ATeamWithoutCouplingsHasNothingToExplain) {
  Team team;
  team.add(Multirotor{});
  EXPECT_TRUE(explain(team).pairs.empty());
  EXPECT_THAT(to_string(explain(team), team), HasSubstr("no couplings"));
}

}  // namespace
}  // namespace sightline
