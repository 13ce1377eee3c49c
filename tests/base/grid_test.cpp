#include "sightline/base/grid.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

Pairs by_grid(Grid& grid, const std::vector<Vec3<double>>& p, double reach) {
  Pairs pairs;
  grid.each_pair(p, reach, [&](int i, int j) { pairs.emplace_back(i, j); });
  return pairs;
}

Pairs one_by_one(const std::vector<Vec3<double>>& p, double reach) {
  Pairs pairs;
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = i + 1; j < p.size(); ++j) {
      if (norm(p[i] - p[j]) < reach) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

TEST(Grid, FindsThePairsThatTryingAllOfThemFindsAndInTheirOrder) {
  Random random(1);
  Grid grid(100);
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<Vec3<double>> p(random() % 101);
    const double wide = std::pow(10.0, uniform(random, -2.0, 3.0)), reach = uniform(random, 0.0, 5.0);
    for (Vec3<double>& q : p)
      q = {uniform(random, -wide, wide), uniform(random, -wide, wide), uniform(random, -3, 3)};
    EXPECT_EQ(by_grid(grid, p, reach), one_by_one(p, reach)) << trial;
  }
}

TEST(Grid, PointsOnTheEdgesOfCellsAreNotMissed) {
  Random random(2);
  Grid grid(60);
  for (int trial = 0; trial < 200; ++trial) {
    const double reach = uniform(random, 0.1, 3.0);
    std::vector<Vec3<double>> p(60);
    const auto edge = [&] {
      const double x = reach * (static_cast<double>(random() % 7) - 3.0);
      return random() % 2 == 0 ? x : std::nextafter(x, random() % 2 == 0 ? -1e9 : 1e9);
    };
    for (Vec3<double>& q : p) q = {edge(), edge(), edge()};
    EXPECT_EQ(by_grid(grid, p, reach), one_by_one(p, reach)) << trial;
  }
}

TEST(Grid, NothingIsMissedFarOutAndWhatIsNotFiniteIsNearNone) {
  Random random(3);
  Grid grid(40);
  const double inf = std::numeric_limits<double>::infinity();
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Vec3<double>> p;
    for (int i = 0; i < 10; ++i) {
      const Vec3<double> q = {uniform(random, -1, 1) * std::pow(10.0, uniform(random, 0, 300)),
                              uniform(random, -1e9, 1e9), 1e7};
      p.push_back(q);
      p.push_back(q + Vec3<double>{0.0, uniform(random, -2, 2), uniform(random, -2, 2)});
      p.push_back({uniform(random, -1, 1), random() % 2 == 0 ? inf : -inf, 0.0});
      p.push_back({0.0, std::numeric_limits<double>::quiet_NaN(), 0.0});
    }
    EXPECT_EQ(by_grid(grid, p, 2.5), one_by_one(p, 2.5)) << trial;
  }
}

TEST(Grid, WithoutAReachNothingIsNear) {
  Grid grid(2);
  const std::vector<Vec3<double>> p(2);
  for (const double reach : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(by_grid(grid, p, reach).empty()) << reach;
  }
  EXPECT_EQ(by_grid(grid, {{1, 2, 3}, {4e5, 5, 6}}, std::numeric_limits<double>::infinity()).size(), 1U);
}

}  // namespace
}  // namespace sightline
