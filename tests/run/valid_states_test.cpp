#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "sightline/loop.hpp"
#include "sightline/model.hpp"
#include "sightline/robots.hpp"

namespace sightline {
namespace {

using Numbers = std::vector<double>;

Team mixed() {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  team.add(Obstacle{.name = "o"});
  team.add(PointMass{}, {.name = "m"});
  return team;
}
const Numbers start = {0, 0, 1, 1, 0, 0, 0, /**/ 4, 0, 1, 0, 0, 0, /**/ 1, 2, 3, 0, 0, 0};

TEST(ValidStates, AreNumbersWithAHeadingWhateverIsMeasured) {
  const Team team = mixed();
  ValidStates states(team, start);
  Numbers expected = start, stamps(3, -infinity);
  std::mt19937_64 random(1);
  const Numbers wild = {std::nan(""), infinity, -infinity, 2e9, -1e300, 0.3, -2.0};
  std::normal_distribution<double> normal;
  int taken = 0;
  for (int k = 0; k < 5000; ++k) {
    Numbers x(start.size());
    for (double& v : x) v = normal(random);
    if (k % 2 == 0) x[random() % x.size()] = wild[random() % wild.size()];
    if (k % 5 == 0) x[3] = x[4] = 0.0;
    const Numbers times(3, 0.01 * k);
    (void)states.take(x, times);
    const std::vector<std::pair<std::size_t, std::size_t>> places = {{0, 7}, {7, 6}, {13, 6}};
    for (std::size_t b = 0; b < places.size(); ++b) {
      const auto [from, n] = places[b];
      bool good = b != 0 || std::hypot(x[3], x[4]) > 1e-6;
      for (std::size_t i = from; i < from + n; ++i) good = good && std::abs(x[i]) <= 1e9;
      ASSERT_EQ(states.is_valid(BodyId{static_cast<int>(b)}), good);
      if (good) {
        std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(from), n,
                    expected.begin() + static_cast<std::ptrdiff_t>(from));
        stamps[b] = times[b];
        ++taken;
      }
      ASSERT_EQ(states.stamps()[b], stamps[b]);
    }
    for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(states[i], expected[i]);
  }
  EXPECT_GT(taken, 5000);
}

TEST(ValidStates, AreAtRestBeforeTheFirstMeasurementWhereTheStartIsNoState) {
  Numbers broken = start;
  broken[3] = broken[4] = 0.0;
  broken[8] = std::nan("");
  const ValidStates states(mixed(), broken);
  EXPECT_EQ(states[2], 0.0);
  EXPECT_EQ(std::hypot(states[3], states[4]), 1.0);
  EXPECT_EQ(states[8], 0.0);
  EXPECT_EQ(states[14], 2.0);
  for (int b = 0; b < 3; ++b) {
    EXPECT_FALSE(states.is_valid(BodyId{b}));
    EXPECT_EQ(states.stamps()[static_cast<std::size_t>(b)], -infinity);
  }
}

TEST(ValidStates, WhatFollowsFromABodyThatIsNotValidIsNotValidEither) {
  const Team team = mixed();
  ValidStates measured(team, start), predicted(team, start);
  Numbers x = start;
  x[0] = std::nan("");
  (void)measured.take(x, Numbers{1.0, 1.0, std::nan("")});
  (void)predicted.take(start, measured);
  EXPECT_FALSE(predicted.is_valid(BodyId{0}));
  EXPECT_TRUE(predicted.is_valid(BodyId{1}));
  EXPECT_FALSE(predicted.is_valid(BodyId{2})) << "measured at no time";
  EXPECT_EQ(predicted.stamps()[1], 1.0);
  x = start;
  x[7] = infinity;
  (void)measured.take(start, Numbers(3, 2.0));
  (void)predicted.take(x, measured);
  EXPECT_TRUE(predicted.is_valid(BodyId{0}));
  EXPECT_FALSE(predicted.is_valid(BodyId{1}));
}

}  // namespace
}  // namespace sightline
