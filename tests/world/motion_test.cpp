#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/sensors.hpp"
#include "sightline/world.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/period.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::control_period;
using Numbers = std::vector<double>;
constexpr int p_O = 7, v_O = 10;  // of the obstacle in the state

Team robot_and_obstacle() {
  Team team;
  team.add(Multirotor{});
  team.add(Obstacle{.name = "obstacle"});
  return team;
}
const AgentId uav0{BodyId{0}};
const BodyId obstacle{1};

Vec3<double> at(std::span<const double> x, int offset) {
  const auto i = static_cast<std::size_t>(offset);
  return {x[i], x[i + 1], x[i + 2]};
}
Vec3<double> robot_of(std::span<const double> x) { return at(x, 0); }
Vec3<double> obstacle_of(std::span<const double> x) { return at(x, p_O); }

Numbers start_with(const Vec3<double>& p) { return {0, 0, 1, 1, 0, 0, 0, p.x, p.y, p.z, 0, 0, 0}; }

/// A plant whose obstacle moves; the robot flies a curve, up and down.
struct MovingObstacle {
  Plant plant;

  MovingObstacle(const Motion& motion, const Vec3<double>& p, std::uint64_t seed = 1)
      : plant(robot_and_obstacle(), start_with(start_of(motion).value_or(p)),
              {.seed = seed, .motions = {{obstacle, motion}}}) {}

  void step() {
    const double t = plant.time();
    const Numbers u = {0.4, 0.2 * std::sin(t), 0.3 * std::cos(0.7 * t), 0.5};
    ASSERT_TRUE(plant.step(u, control_period));
  }
  Vec3<double> p() const { return obstacle_of(plant.x()); }
  Vec3<double> v() const { return at(plant.x(), v_O); }
  Vec3<double> to_robot() const { return robot_of(plant.x()) - p(); }
};

const std::vector<Motion> all_motions = {
    PathMotion{.points = {{3, 0, 1}, {3, 2, 1}, {1, 2, 2}}, .speed = 0.7, .end = PathMotion::End::round},
    WaypointsMotion{{.times = {0, 4, 9, 20},
                     .p = {{3, 0, 1}, {3, 2, 1}, {1, 2, 2}, {1, 0, 1}},
                     .v = {{0, 0, 0}, {-0.5, 0.5, 0}, {0, 0, 0.2}, {0, 0, 0}}}},
    CircleMotion{.centre = {0, 0, 1}, .radius = 2, .rate = 0.4, .phase = 1},
    ChaseMotion{.agent = uav0, .speed = 0.6, .standoff = 0.8},
    CrossMotion{.agent = uav0, .at = 1, .speed = 0.9, .miss = 0.2},
    HandMotion{.agent = uav0, .at = 2, .from = {-4, 1.5, 1.2}, .speed = 0.3, .standoff = 0.9},
    AdversaryMotion{.agent = uav0, .speed = 1.5},
    AdversaryMotion{.agent = uav0, .speed = 1.5, .within = AdversaryMotion::Within::space},
};

TEST(Motions, TheVelocityShownIsTheOneHeldOverTheNextStepAndNeverAboveTheTopSpeed) {
  for (const Motion& motion : all_motions) {
    MovingObstacle world(motion, {3, 1, 0.5});
    for (int k = 0; k < 3000; ++k) {
      const Vec3<double> p = world.p(), v = world.v();
      ASSERT_LE(norm(v), top_speed(motion) + 1e-9) << "motion " << motion.index() << " step " << k;
      world.step();
      const bool enters = std::holds_alternative<HandMotion>(motion) && k == 199;
      const Vec3<double> moved = world.p() - (p + control_period * v);
      if (!enters) {
        ASSERT_LE(norm(moved), 1e-12) << "motion " << motion.index() << " step " << k;
      }
    }
  }
}

TEST(Motions, ABodyWithoutMotionFliesTheSameBesideOneThatHas) {
  Team team = robot_and_obstacle();
  team.add(Obstacle{.name = "other"});
  Numbers x0 = start_with({3, 0, 1});
  x0[v_O] = 0.1;
  x0.insert(x0.end(), {5, 5, 1, 0, 0, 0});
  Plant alone(team, x0), beside(team, x0, {.motions = {{BodyId{2}, all_motions.back()}}});
  for (int k = 0; k < 500; ++k) {
    const Numbers u = {0.1, 0.2, 0.3, 0.4};
    alone.step(u, control_period);
    beside.step(u, control_period);
    const auto first = [](const Plant& plant) {
      return Numbers(plant.x().begin(), plant.x().begin() + p_O + 6);
    };
    ASSERT_EQ(first(alone), first(beside)) << k;
  }
}

TEST(Motions, OnACircleTheBodyIsWhereTheFormulaSaysForAsLongAsOneFlies) {
  const CircleMotion circle{.centre = {0.2, -0.3, 1}, .radius = 1, .rate = -1.0, .phase = 0.5};
  MovingObstacle world(circle, {});
  for (int k = 0; k <= 20000; ++k) {
    const double a = circle.phase + circle.rate * control_period * k;
    const Vec3<double> expected = circle.centre + Vec3<double>{std::cos(a), std::sin(a), 0};
    ASSERT_LE(norm(world.p() - expected), 1e-9) << k;
    world.step();
  }
}

TEST(Motions, APathIsWalkedAtItsSpeedToItsEndOrRoundAndRound) {
  PathMotion path{.points = {{3, 0, 1}, {3, 2, 1}, {3, 2, 2}}, .speed = 0.5};
  MovingObstacle once(path, {});
  path.end = PathMotion::End::round;
  MovingObstacle round(path, {});
  const double length = 3 + std::sqrt(5.0);
  for (int k = 0; k <= 4000; ++k) {
    const double s = 0.5 * control_period * k, once_s = std::min(s, 3.0);
    const auto place = [](double along) {
      if (along <= 2) return Vec3<double>{3, along, 1};
      if (along <= 3) return Vec3<double>{3, 2, along - 1};
      const double w = (along - 3) / std::sqrt(5.0);
      return Vec3<double>{3, 2 - 2 * w, 2 - w};
    };
    ASSERT_LE(norm(once.p() - place(once_s)), 1e-9) << k;
    ASSERT_LE(norm(round.p() - place(std::fmod(s, length))), 1e-6) << k;
    once.step();
    round.step();
  }
}

TEST(Motions, AChaseHeadsForTheRobotAndRestsAtTheStandoff) {
  const ChaseMotion chase{.agent = uav0, .speed = 2.0, .standoff = 0.8};
  MovingObstacle world(chase, {6, -2, 3});
  bool stood = false;
  for (int k = 0; k < 2000; ++k) {
    const Vec3<double> way = world.to_robot(), v = world.v();
    const double gap = norm(way) - chase.standoff;
    if (gap > chase.speed * control_period) {
      EXPECT_NEAR(norm(v), chase.speed, 1e-9);
    } else {
      stood = true;
      EXPECT_NEAR(norm(v), std::max(0.0, gap) / control_period, 1e-6);
    }
    EXPECT_NEAR(dot(v, way), norm(v) * norm(way), 1e-9);
    world.step();
  }
  EXPECT_TRUE(stood);
}

TEST(Motions, ACrossingBodyMeetsARobotThatKeepsItsVelocityOrMissesItBySoMuch) {
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3<double> p = {uniform(random, -5, 5), uniform(random, -5, 5), uniform(random, 0, 2)};
    const double miss = trial % 2 == 0 ? 0.0 : uniform(random, -0.5, 0.5);
    const double v_f = uniform(random, -0.5, 0.5), angle = uniform(random, -3, 3);
    if (norm(p - Vec3<double>{0, 0, 1}) < 1) continue;
    // Without drag and command the robot keeps its velocity.
    Team team;
    team.add(Multirotor{.a_f = 0, .a_s = 0});
    team.add(Obstacle{.name = "obstacle"});
    const Numbers x0 = {0, 0, 1, std::cos(angle), std::sin(angle), v_f, 0.2, p.x, p.y, p.z, 0, 0, 0};
    Plant plant(team, x0, {.motions = {{obstacle, CrossMotion{uav0, 0.5, 1.2, miss}}}});
    double nearest = 1e9;
    for (int k = 0; k < 3000; ++k) {
      if (k < 50) {
        ASSERT_EQ(norm(at(plant.x(), v_O)), 0.0);
      }
      nearest = std::min(nearest, norm(robot_of(plant.x()) - obstacle_of(plant.x())));
      plant.step(Numbers(4, 0.0), control_period);
    }
    EXPECT_NEAR(norm(at(plant.x(), v_O)), 1.2, 1e-12);
    if (miss == 0.0) {
      EXPECT_LE(nearest, 0.02) << trial;
    } else {
      EXPECT_LE(nearest, std::fabs(miss) + 0.02) << trial;
    }
  }
}

TEST(Motions, AHandWaitsElsewhereThenIsThereAllAtOnceAndFollowsUpToItsStandoff) {
  const HandMotion hand{.agent = uav0, .at = 2, .from = {-4, 1.5, 1.2}, .speed = 0.9, .standoff = 0.9};
  const Vec3<double> waits = {-30, 0, 1};
  MovingObstacle world(hand, waits);
  double nearest = 1e9;
  for (int k = 0; k < 3000; ++k) {
    if (k < 200) {
      ASSERT_EQ(norm(world.p() - waits) + norm(world.v()), 0.0) << k;
    } else if (k == 200) {
      ASSERT_EQ(norm(world.p() - hand.from), 0.0);
      ASSERT_NEAR(norm(world.v()), hand.speed, 1e-12);
    }
    // The robot may come nearer by itself.
    if (norm(world.to_robot()) <= hand.standoff) {
      ASSERT_EQ(norm(world.v()), 0.0) << k;
    }
    nearest = std::min(nearest, norm(world.to_robot()));
    world.step();
  }
  EXPECT_LE(nearest, hand.standoff + 0.01);
}

TEST(Motions, AnAdversaryTurnsOnlyAtItsTimesSeededInItsPlaneAndAimsAsOftenAsItSays) {
  AdversaryMotion adversary{.agent = uav0, .speed = 1.5, .every = 0.5, .aim = 0.3};
  MovingObstacle world(adversary, {4, 0, 0.5}), same(adversary, {4, 0, 0.5}),
      other(adversary, {4, 0, 0.5}, 2);
  int turns = 0, aimed = 0, full = 0;
  bool differs = false;
  for (int k = 0; k < 50 * 2000; ++k) {
    const Vec3<double> before = world.v();
    for (MovingObstacle* one : {&world, &same, &other}) one->step();
    const Vec3<double> v = world.v(), way = world.to_robot();
    ASSERT_EQ(norm(v - same.v()), 0.0);
    ASSERT_EQ(world.p().z, 0.5);
    differs = differs || norm(v - other.v()) > 0;
    if ((k + 1) % 50 != 0) {
      ASSERT_EQ(norm(v - before), 0.0) << k;
      continue;
    }
    ++turns;
    full += norm(v) > 1.5 - 1e-9;
    aimed += v.x * way.x + v.y * way.y > (1 - 1e-9) * norm(v) * std::hypot(way.x, way.y);
  }
  EXPECT_TRUE(differs);
  EXPECT_EQ(turns, 2000);
  EXPECT_NEAR(aimed, 0.3 * turns, 4 * std::sqrt(0.21 * turns));
  EXPECT_NEAR(full, 0.5 * turns, 4 * std::sqrt(0.25 * turns));
}

TEST(Motions, InSpaceAnAdversarysWaysSpreadEvenlyOverTheSphere) {
  MovingObstacle world(AdversaryMotion{uav0, 1.5, 0.01, 0.0, AdversaryMotion::Within::space}, {4, 0, 0.5});
  Vec3<double> sum{}, squares{};
  const int n = 20000;
  for (int k = 0; k < n; ++k) {
    world.step();
    const Vec3<double> e = (1 / norm(world.v())) * world.v();
    sum = sum + e;
    squares = squares + Vec3<double>{square(e.x), square(e.y), square(e.z)};
  }
  for (const double c : {sum.x, sum.y, sum.z}) EXPECT_LE(std::fabs(c), 4 * std::sqrt(n / 3.0));
  for (const double c : {squares.x, squares.y, squares.z}) EXPECT_NEAR(c / n, 1.0 / 3, 0.01);
}

TEST(Motions, StepsOfAnotherLengthLeaveTheBodyOnItsWay) {
  const CircleMotion circle{.centre = {0, 0, 1}, .radius = 1, .rate = 0.8, .phase = 0};
  Plant plant(robot_and_obstacle(), start_with(*start_of(circle)), {.motions = {{obstacle, circle}}});
  for (const double step : {0.01, 0.005, 0.02, 0.013, 0.01}) {
    plant.step(Numbers(4, 0.0), step);
    const double a = circle.rate * plant.time();
    EXPECT_LE(norm(obstacle_of(plant.x()) - Vec3<double>{std::cos(a), std::sin(a), 1}), 1e-12);
  }
}

TEST(Motions, AVelocityThatIsUnknownIsSeenAsZeroWithAndWithoutNoise) {
  const Team team = robot_and_obstacle();
  for (const double noise : {0.0, 0.1}) {
    Sensor sensor(team, {.noise = {.velocity = noise}, .velocity_unknown = {obstacle}});
    Numbers x = start_with({3, 0, 1});
    x[5] = 0.5, x[v_O] = 0.7;
    const auto seen = sensor.measure(0.0, x);
    EXPECT_EQ(norm(at(seen, v_O)), 0.0);
    EXPECT_EQ(norm(obstacle_of(seen) - obstacle_of(x)), 0.0);
    EXPECT_NE(seen[5], 0.0);
  }
}

TEST(Motions, WhatCannotBeIsRefusedBySentence) {
  const Team team = robot_and_obstacle();
  const auto said = [&](const std::vector<BodyMotion>& motions) {
    return refusal_of([&] { Motions(team, motions, 1); });
  };
  EXPECT_EQ(said({{uav0, CircleMotion{}}}), "motion of body 0, expected a target or an obstacle of the team");
  EXPECT_EQ(said({{obstacle, ChaseMotion{}}}),
            "the motion of \"obstacle\" follows body -1, expected a robot");
  EXPECT_EQ(said({{obstacle, CircleMotion{}}, {obstacle, CircleMotion{}}}),
            "\"obstacle\" has two motions, expected one");
  EXPECT_EQ(said({{obstacle, PathMotion{{{0, 0, 0}}}}}),
            "path.points has fewer than two, expected two or more");
  EXPECT_EQ(said({{obstacle, PathMotion{{{1, 0, 0}, {1, 0, 0}}}}}),
            "path.points = 0, expected points that are not all the same, a length > 0 m");
  EXPECT_EQ(said({{obstacle, AdversaryMotion{.agent = uav0, .aim = 1.5}}}),
            "adversary.aim = 1.5, expected in [0, 1]");
}

/// The obstacle's place and speed over a flight in which events move it.
struct Carried {
  std::vector<Vec3<double>> p;
  double fastest = 0.0;
};
Carried carried(double speed_max, const std::vector<Surroundings>& received) {
  Plant plant(robot_and_obstacle(), start_with({2, 0, 1}), {.speed_max = {speed_max}});
  Carried seen;
  for (int k = 0; k < 400; ++k) {
    const auto newest = std::find_if(received.rbegin(), received.rend(), [&](const Surroundings& around) {
      return around.moves[0].begin <= k * control_period + 1e-9;
    });
    if (newest != received.rend()) plant.surround(*newest);
    (void)plant.step(Numbers(4, 0.0), control_period);
    const auto x = plant.x();
    seen.p.push_back(obstacle_of(x));
    seen.fastest = std::max(seen.fastest, norm(at(x, v_O)));
  }
  return seen;
}
Surroundings move_to(const Vec3<double>& to, double begin, double duration) {
  return {.moves = {{obstacle, to, begin, duration}}};
}

TEST(Motions, ABodyThatAnEventMovesGoesThereInItsTimeAndRests) {
  const Carried seen = carried(0.0, {move_to({3, 1, 1}, 1.0, 1.0)});
  EXPECT_EQ(seen.p[98].x, 2.0);
  EXPECT_NEAR(seen.p[149].x, 2.5, 0.02);
  EXPECT_NEAR(seen.p[149].y, 0.5, 0.02);
  EXPECT_NEAR(seen.p[201].x, 3.0, 1e-12);
  EXPECT_EQ(seen.p[399].x, seen.p[250].x);
  EXPECT_NEAR(seen.fastest, 1.5 * std::sqrt(2.0), 0.01);
}

TEST(Motions, ABodyThatAnEventMovesIsNoFasterThanItMayBe) {
  const Carried seen = carried(0.5, {move_to({3, 0, 1}, 1.0, 0.1)});
  EXPECT_LE(seen.fastest, 0.5 + 1e-9);
  EXPECT_NEAR(seen.p[399].x, 2.0 + 1.0 * blended(4.0, 1.0, 3.0), 1e-9);
}

TEST(Motions, ABodyThatIsMovedAgainGoesOnFromWhereItIs) {
  const Carried seen = carried(0.0, {move_to({3, 0, 1}, 1.0, 1.0), move_to({2, 0, 1}, 1.5, 1.0)});
  for (std::size_t k = 1; k < seen.p.size(); ++k) EXPECT_LE(norm(seen.p[k] - seen.p[k - 1]), 0.016);
  EXPECT_NEAR(seen.p[399].x, 2.0, 1e-12);
}

TEST(Motions, ABodyThatComesAgainStandsWhereItBegan) {
  Plant plant(robot_and_obstacle(), start_with({2, 0, 1}));
  const Surroundings around = move_to({3, 0, 1}, 0.0, 0.1);
  const auto fly = [&](int periods) {
    for (int k = 0; k < periods; ++k) (void)plant.step(Numbers(4, 0.0), control_period);
  };
  plant.surround(around);
  fly(50);
  EXPECT_NEAR(obstacle_of(plant.x()).x, 3.0, 1e-12);
  for (const Presence there : {Presence::absent, Presence::hold}) {
    plant.set_presence(std::vector{Presence::steered, there});
    plant.surround(around);
    fly(1);
  }
  fly(50);
  EXPECT_NEAR(obstacle_of(plant.x()).x, 2.0, 0.02);
}

TEST(Motions, AWindThatAnEventBringsComesUpOverItsTime) {
  Plant plant(robot_and_obstacle(), start_with({9, 0, 1}));
  plant.surround({.wind = Surroundings::Wind{{1, 0, 0}, 0.0, 1.0}});
  std::vector<double> speed = {0.0};
  for (int k = 0; k < 200; ++k) {
    (void)plant.step(Numbers(4, 0.0), control_period);
    speed.push_back(plant.x()[5]);
    EXPECT_LE(speed[speed.size() - 1] - speed[speed.size() - 2], 1.0 * control_period);
  }
  EXPECT_LT(speed[10], 0.01);
  EXPECT_GT(speed[200], 0.1);
}

}  // namespace
}  // namespace sightline
