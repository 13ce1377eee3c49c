#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(SpeedLimit, OfAMultirotorItIsABoundOnItsForwardAndSidewardSpeed) {
  Random random(1);
  const Model model = Multirotor{};
  for (int k = 0; k < 10'000; ++k) {
    const double psi = uniform(random, -3, 3), v_f = uniform(random, -2, 2), v_s = uniform(random, -2, 2);
    const double max = uniform(random, 0.1, 2);
    const std::array<double, 7> x = {1, 2, 3, std::cos(psi), std::sin(psi), v_f, v_s};
    const auto u = uniform_array<4>(random, -1, 1);
    const Limit limit = SpeedLimit{max};
    const double c = limit(model.sight(x.data(), u.data()), x, u);
    EXPECT_NEAR(c, (v_f * v_f + v_s * v_s) / (max * max) - 1, 1e-12 / (max * max));
  }
}

TEST(InputDisc, ItIsABoundOnTheLengthOfTwoInputs) {
  Random random(2);
  for (int k = 0; k < 10'000; ++k) {
    const auto u = uniform_array<4>(random, -1, 1);
    const double radius = uniform(random, 0.2, 2);
    const Limit tilt = InputDisc{.radius = radius}, others = InputDisc{.radius = radius, .i = 3, .j = 1};
    EXPECT_EQ(tilt({}, {}, u) <= 0, std::hypot(u[0], u[1]) <= radius);
    EXPECT_EQ(others({}, {}, u) <= 0, std::hypot(u[3], u[1]) <= radius);
    EXPECT_EQ(tilt.inputs(), 2);
    EXPECT_EQ(others.inputs(), 4);
  }
}

TEST(SpeedLimit, ALeastSpeedIsKeptAsAGreatestIs) {
  Random random(3);
  const Model model = PointMass{};
  for (int k = 0; k < 10'000; ++k) {
    const double max = uniform(random, 1, 20), min = uniform(random, 0.1, 0.9) * max;
    const double psi = uniform(random, -3, 3), speed = uniform(random, 0, 1.5 * max);
    const std::array<double, 6> x = {1, 2, 3, speed * std::cos(psi), speed * std::sin(psi), 5};
    const auto u = uniform_array<3>(random, -1, 1);
    const Limit limit = SpeedLimit{max, min};
    const double c = limit(model.sight(x.data(), u.data()), x, u);
    EXPECT_EQ(c <= 0, speed >= min && speed <= max) << speed << " of " << min << " to " << max;
    EXPECT_GE(c, -1);
  }
}

TEST(Limit, AMaximumBelowItsMinimumAndAnInputTwiceAreRefused) {
  EXPECT_THAT(refusal_of([] { Limit(SpeedLimit{.max = 0.5, .min = 0.5}); }),
              HasSubstr("speed.min = 0.5, expected below max"));
  EXPECT_THAT(refusal_of([] { Limit(InputDisc{.i = 1, .j = 1}); }), HasSubstr("input_disc.j = 1"));
}

}  // namespace
}  // namespace sightline
