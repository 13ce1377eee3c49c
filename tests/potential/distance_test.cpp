#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "tests/support/apart.hpp"

namespace sightline {
namespace {

/// l of two robots D apart, in a random direction.
template <class P>
double at(const P& potential, double D, Random& random) {
  const auto [a, b] = random_sights_apart(D, random);
  return potential(a, b);
}

TEST(KeepOut, PushesApartAtEveryDistance) {
  Random random(1);
  for (int k = 0; k < 5000; ++k) {
    const KeepOut keep_out{.d_min = uniform(random, 0.3, 2), .kappa_A = uniform(random, 0.5, 5)};
    const double D = uniform(random, 0.1, 3);
    EXPECT_GT(at(keep_out, D, random), at(keep_out, 1.01 * D, random));
  }
}

TEST(Cohesion, PullsTogetherAtEveryDistance) {
  Random random(2);
  for (int k = 0; k < 5000; ++k) {
    const Cohesion cohesion{.d_max = uniform(random, 0.5, 3), .kappa_A = uniform(random, 0.5, 5)};
    const double D = uniform(random, 0.1, 20);
    EXPECT_LE(at(cohesion, D, random), at(cohesion, 1.01 * D, random) * (1 + 1e-14));
    const double outside = cohesion.d_max * uniform(random, 1.0, 1.2);
    EXPECT_LT(at(cohesion, outside, random), at(cohesion, 1.01 * outside, random));
  }
}

TEST(Distance, HalfOfTheStepIsAtTheLimit) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const KeepOut keep_out{.d_min = uniform(random, 0.3, 2)};
    const Cohesion cohesion{.d_max = uniform(random, 0.3, 2)};
    const double near = square(keep_out.d_min), far = square(cohesion.d_max);
    EXPECT_NEAR(at(keep_out, keep_out.d_min, random), 0.5 * (keep_out.kappa_H - keep_out.kappa_G * near),
                1e-12);
    EXPECT_NEAR(at(cohesion, cohesion.d_max, random), 0.5 * (cohesion.kappa_H + cohesion.kappa_G * far),
                1e-12);
  }
}

TEST(Distance, TheTwoRobotsMayChangePlaces) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const Sight<double> a = random_sight(random, 2), b = random_sight(random, 2);
    EXPECT_EQ(KeepOut{}(a, b), KeepOut{}(b, a));
    EXPECT_EQ(Cohesion{}(a, b), Cohesion{}(b, a));
    EXPECT_EQ(KeepOut{}.violation(a, b), KeepOut{}.violation(b, a));
  }
}

TEST(Distance, TheViolationIsInMetres) {
  Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const Sight<double> a = random_sight(random, 2), b = random_sight(random, 2);
    const double D = std::hypot(a.p.x - b.p.x, a.p.y - b.p.y, a.p.z - b.p.z);
    EXPECT_NEAR(KeepOut{.d_min = 1.2}.violation(a, b), 1.2 - D, 1e-14);
    EXPECT_NEAR(Cohesion{.d_max = 1.7}.violation(a, b), D - 1.7, 1e-14);
  }
}

}  // namespace
}  // namespace sightline
