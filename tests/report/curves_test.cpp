#include "sightline/report/curves.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(Curves, ALabelIsCutBetweenTwoCharacters) {
  EXPECT_EQ(label("uav0"), "uav0");
  EXPECT_EQ(label("ψψψψ", 4), "ψψψψ");
  EXPECT_EQ(label("ψψψψψ", 4), "ψψψψ…");
}

TEST(Curves, MoreBodiesHaveFewerRowsEachAndNoExtremeIsLost) {
  Random random(1);
  std::size_t before = 4000;
  for (const std::size_t bodies : {1u, 16u, 100u, 1024u}) {
    Recording r;
    r.period = 0.01;
    r.bodies.resize(bodies);
    std::vector<double> y;
    for (int k = 0; k < 5000; ++k) {
      r.time.push_back(0.01 * k);
      y.push_back(uniform(random, -1, 1));
    }
    y[1234] = 7, y[4321] = -8;
    const Curves curves(r);
    const auto curve = curves.over_time("y", 0, Drawing::Mark::line, y);
    EXPECT_LT(curve.y.size(), before);
    EXPECT_LE(bodies * curve.y.size(), 30'000u);
    before = curve.y.size();
    EXPECT_EQ(*std::max_element(curve.y.begin(), curve.y.end()), 7);
    EXPECT_EQ(*std::min_element(curve.y.begin(), curve.y.end()), -8);
    EXPECT_EQ(curves.level("", 0, 2.0).x, (std::vector<double>{0.0, curves.end()}));
  }
}

}  // namespace
}  // namespace sightline
