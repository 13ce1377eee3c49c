#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(PointMass, FliesAsItsLinearEquationIsSolved) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const double drag = k % 2 == 0 ? 0.0 : uniform(random, 0.2, 2), t = 1.0;
    const Model point = PointMass{drag};
    const auto start = uniform_array<6>(random, -2, 2);
    const auto u = uniform_array<3>(random, -2, 2);
    auto x = start;
    for (int step = 0; step < 100; ++step) point.step(x.data(), u.data(), 0.01);
    const double decay = std::exp(-drag * t);
    const double a = drag > 0 ? (1 - decay) / drag : t;        // v(t) = decay v + a u
    const double b = drag > 0 ? (t - a) / drag : 0.5 * t * t;  // p(t) = p + a v + b u
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(x[i + 3], decay * start[i + 3] + a * u[i], 1e-9);
      EXPECT_NEAR(x[i], start[i] + a * start[i + 3] + b * u[i], 1e-9);
    }
  }
}

TEST(PointMass, HeadsAlongXWhateverItWasTold) {
  const PointMass point;
  const Pose<double> pose = point.pose(point.at_rest({{1, 2, 3}, {0.0, 1.0}}));
  EXPECT_EQ(pose.d.x, 1.0);
  EXPECT_EQ(pose.d.y, 0.0);
}

}  // namespace
}  // namespace sightline
