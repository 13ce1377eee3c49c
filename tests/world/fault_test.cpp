#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sightline/sensors.hpp"
#include "sightline/world.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using test::two_robots;
using Numbers = std::vector<double>;

// The true state of both robots in period k.
Numbers state_at(int k) {
  const double s = 0.01 * k;
  return {s, 2 * s, 1, 1, 0, 1, 0, /**/ -s, s, 2, 0, 1, 0.5, 0};
}

struct Seen {
  Numbers x, stamps;
};

// What a sensor with these faults gives over some periods.
std::vector<Seen> seen(const std::vector<Fault>& faults, int periods, const Noise& noise = {},
                       double delay = 0.0) {
  Sensor sensor(two_robots(), {.seed = 5, .noise = noise, .delay = delay, .faults = faults});
  std::vector<Seen> all;
  for (int k = 0; k < periods; ++k) {
    const auto x = sensor.measure(0.01 * k, state_at(k));
    all.push_back({{x.begin(), x.end()}, {sensor.stamps().begin(), sensor.stamps().end()}});
  }
  return all;
}

TEST(Fault, OutsideItsTimeAndItsBodyTheMeasurementIsAsWithoutIt) {
  for (const FaultKind kind :
       {FaultKind::dropout, FaultKind::delay, FaultKind::freeze, FaultKind::nan, FaultKind::jump}) {
    for (const double noise : {0.0, 0.1}) {
      const Noise n{.position = noise, .heading = noise, .velocity = noise};
      const auto with =
          seen({{.kind = kind, .body = BodyId{0}, .from = 0.1, .until = 0.3, .offset = {1, 0, 0}}}, 60, n);
      const auto without = seen({}, 60, n);
      for (std::size_t k = 0; k < with.size(); ++k) {
        const bool struck = k >= 10 && k < 30;
        const auto same = [&](std::size_t i) {
          const double a = with[k].x[i], b = without[k].x[i];
          return a == b;
        };
        for (std::size_t i = struck ? 7 : 0; i < 14; ++i) ASSERT_TRUE(same(i)) << to_string(kind) << " " << k;
        for (std::size_t i = struck ? 1 : 0; i < 2; ++i)
          ASSERT_EQ(with[k].stamps[i], 0.01 * static_cast<double>(k));
      }
    }
  }
}

TEST(Fault, ADropoutLeavesTheLastMeasurementWithItsTime) {
  const auto all = seen({{.kind = FaultKind::dropout, .body = BodyId{1}, .from = 0.1, .until = 0.3}}, 40);
  for (std::size_t k = 10; k < 30; ++k) {
    EXPECT_EQ(Numbers(all[k].x.begin() + 7, all[k].x.end()), Numbers(all[9].x.begin() + 7, all[9].x.end()));
    EXPECT_EQ(all[k].stamps[1], 0.09);
  }
  EXPECT_EQ(all[30].stamps[1], 0.3);
}

TEST(Fault, ADropoutOfSomeProbabilityStrikesThatOften) {
  for (const double p : {0.0, 0.2, 0.7, 1.0}) {
    const auto all =
        seen({{.kind = FaultKind::dropout, .body = BodyId{0}, .from = 0.01, .probability = p}}, 5000);
    int lost = 0;
    for (std::size_t k = 1; k < all.size(); ++k) lost += all[k].stamps[0] == all[k - 1].stamps[0] ? 1 : 0;
    EXPECT_NEAR(lost / 4999.0, p, 0.02);
  }
}

TEST(Fault, ADelayGivesPastStatesWithTheirTimesBesidesTheSensorsOwn) {
  const auto all = seen({{.kind = FaultKind::delay, .from = 0.5, .delay = 0.2}}, 100, {}, 0.03);
  for (int k = 0; k < 100; ++k) {
    const int at = k < 50 ? std::max(0, k - 3) : k - 23;
    EXPECT_EQ(all[static_cast<std::size_t>(k)].x, state_at(at)) << k;
    EXPECT_EQ(all[static_cast<std::size_t>(k)].stamps, Numbers(2, 0.01 * at));
  }
}

TEST(Fault, AFreezeRepeatsTheValuesWithFreshTimesWhateverTheNoise) {
  const auto all = seen({{.kind = FaultKind::freeze, .body = BodyId{0}, .from = 0.1}}, 40, {.position = 0.1});
  for (std::size_t k = 10; k < 40; ++k) {
    EXPECT_EQ(Numbers(all[k].x.begin(), all[k].x.begin() + 7),
              Numbers(all[9].x.begin(), all[9].x.begin() + 7));
    EXPECT_EQ(all[k].stamps[0], 0.01 * static_cast<double>(k));
  }
}

TEST(Fault, ANumberThatIsNoneIsTheOneThatIsNamedOrAnyOne) {
  const auto named = seen({{.kind = FaultKind::nan, .body = BodyId{1}, .number = 3}}, 10);
  for (const Seen& one : named) {
    for (std::size_t i = 0; i < 14; ++i) EXPECT_EQ(std::isnan(one.x[i]), i == 10);
  }
  std::vector<int> struck(7, 0);
  for (const Seen& one : seen({{.kind = FaultKind::nan, .body = BodyId{0}}}, 3000)) {
    int bad = 0;
    for (std::size_t i = 0; i < 7; ++i) {
      if (!std::isnan(one.x[i])) continue;
      ++bad;
      ++struck[i];
    }
    ASSERT_EQ(bad, 1);
  }
  for (const int n : struck) EXPECT_NEAR(n, 3000 / 7, 100);
}

TEST(Fault, AJumpMovesThePositionAlone) {
  for (const Seen& one : seen({{.kind = FaultKind::jump, .body = BodyId{0}, .offset = {1, -2, 3}}}, 1)) {
    Numbers expected = state_at(0);
    expected[0] += 1, expected[1] -= 2, expected[2] += 3;
    EXPECT_EQ(one.x, expected);
  }
}

TEST(Fault, OfABodyThatWasNeverSeenTheTimeIsMinusInfinity) {
  const auto all = seen({{.kind = FaultKind::dropout, .body = BodyId{0}, .until = 0.05}}, 10);
  EXPECT_EQ(all[4].stamps[0], -std::numeric_limits<double>::infinity());
  EXPECT_EQ(all[5].stamps[0], 0.05);
}

TEST(Fault, OneFaultLeavesTheChanceOfTheOthersAsItWas) {
  const Fault lossy{.kind = FaultKind::dropout, .body = BodyId{0}, .probability = 0.5};
  const auto alone = seen({lossy}, 200);
  const auto joined = seen({lossy, {.kind = FaultKind::dropout, .body = BodyId{1}, .probability = 0.3}}, 200);
  for (std::size_t k = 0; k < 200; ++k) ASSERT_EQ(alone[k].stamps[0], joined[k].stamps[0]);
}

TEST(Fault, WhatCannotBeIsRefusedByName) {
  const auto refusal = [](const auto& fault) { return refusal_of([&] { fault.check(); }); };
  EXPECT_EQ(refusal(Fault{.from = -1}), "fault.from = -1, expected >= 0 s");
  EXPECT_EQ(refusal(Fault{.from = 2, .until = 1}), "fault.until = 1, expected > from");
  EXPECT_EQ(refusal(Fault{.probability = 1.5}), "fault.probability = 1.5, expected 0 to 1");
  EXPECT_EQ(refusal(Fault{.delay = 11}), "fault.delay = 11, expected 0 to 10 s");
  EXPECT_EQ(refusal(LatePlan{.delay = -1}), "fault.delay = -1, expected 0 to 10 s");
  EXPECT_EQ(refusal(Fault{}), "");
  EXPECT_THROW(Sensor(two_robots(), {.faults = {{.kind = FaultKind::nan, .number = 7}}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace sightline
