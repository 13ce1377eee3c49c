#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "sightline/team.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

struct Six {
  Team team;
  std::vector<AgentId> robots;
  Six() {
    for (int i = 0; i < 6; ++i) robots.push_back(team.add(Multirotor{}));
  }
};

TEST(Swarm, EachPairNearerThanTheRadiusPaysOnce) {
  Random random(1);
  int near = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Six six, pairs;
    const Weighted term = uniform(random, 0.1, 4.0) * PassRight{.delta = 0.3};
    six.team.keep_apart(term, six.robots, 2.6, 15);
    std::vector<double> x;
    for (int i = 0; i < 6; ++i) {
      const Sight<double> s = random_sight(random, 2.0);
      x.insert(x.end(), {s.p.x, s.p.y, s.p.z, s.d.x, s.d.y, s.v.x, s.v.y});
    }
    const std::vector<double> u(24, 0.1);
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = i + 1; j < 6; ++j) {
        const auto p = [&](std::size_t a) { return Vec3<double>{x[7 * a], x[7 * a + 1], x[7 * a + 2]}; };
        if (!(norm(p(i) - p(j)) < 2.6)) continue;
        ++near;
        pairs.team.couple(term, {pairs.robots[i], pairs.robots[j]});
      }
    }
    EXPECT_NEAR(stage_cost(six.team, 0.0, x, u), stage_cost(pairs.team, 0.0, x, u), 1e-12);
  }
  EXPECT_GT(near, 200);
}

TEST(Swarm, WhatThePotentialIsAtTheRadiusMustBeNextToNothing) {
  Six six;
  EXPECT_NO_THROW(six.team.keep_apart(4.0 * KeepOut{}, six.robots, 2.5, 15));
  EXPECT_NO_THROW(six.team.keep_apart(4.0 * TooNear{}, six.robots, 2.5, 15));
  EXPECT_NO_THROW(six.team.keep_apart(4.0 * PassRight{}, six.robots, 2.5, 15));
  EXPECT_EQ(six.team.swarms().size(), 3U);
  EXPECT_THAT(refusal_of([&] { six.team.keep_apart(4.0 * TooNear{}, six.robots, 1.5, 15); }),
              testing::StartsWith("too_near times 4 is or slopes by 0.03"));
  EXPECT_THAT(refusal_of([&] { six.team.keep_apart(1.0 * Cohesion{}, six.robots, 2.5, 15); }),
              testing::HasSubstr("at the radius of 2.5 m, expected at most 0.001"));
}

TEST(Swarm, WhatIsNoFunctionOfTwoPosesDifferenceIsRefused) {
  Six six;
  for (const Weighted& term : {1.0 * RelativeVelocity{}, 1.0 * Bearing{}}) {
    EXPECT_THAT(refusal_of([&] { six.team.keep_apart(term, six.robots, 2.5, 15); }),
                testing::StartsWith(std::string(term.potential.name()) + " depends on more than"));
  }
  EXPECT_EQ(refusal_of([&] { six.team.keep_apart(1.0 * AltitudeBand{}, six.robots, 2.5, 15); }),
            "altitude_band sees one robot alone, expected a potential between two bodies");
}

TEST(Swarm, RobotsRadiusAndCapacityAreChecked) {
  Six six;
  const Weighted term = 1.0 * TooNear{};
  const AgentId a = six.robots[0], b = six.robots[1], rock{six.team.add(Obstacle{"rock"})};
  const auto refusal = [&](std::vector<AgentId> robots, double radius, int capacity) {
    return refusal_of([&] { six.team.keep_apart(term, std::move(robots), radius, capacity); });
  };
  EXPECT_EQ(refusal({a}, 2.5, 1), "1 robots are kept apart, expected at least two");
  EXPECT_EQ(refusal({a, b, a}, 2.5, 1), "agents names \"uav0\" twice, expected each robot once");
  EXPECT_EQ(refusal({a, rock}, 2.5, 1), "\"rock\" is not controlled, expected a robot");
  EXPECT_EQ(refusal({a, b}, 0.0, 1), "radius = 0, expected > 0 m");
  EXPECT_EQ(refusal({a, b}, infinite, 1), "radius = inf, expected > 0 m");
  EXPECT_EQ(refusal({a, b}, 2.5, 0), "capacity = 0, expected at least 1 pair");
  EXPECT_TRUE(six.team.swarms().empty());
}

}  // namespace
}  // namespace sightline
