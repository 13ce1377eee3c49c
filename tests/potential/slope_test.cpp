#include <gtest/gtest.h>

#include "sightline/base.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/apart.hpp"

namespace sightline {
namespace {

/// dl/dD, b moving away from a along `direction`.
template <class P>
double slope(const P& potential, const Sight<double>& a, const Sight<double>& b,
             const Vec3<double>& direction) {
  using Dual = Tangent<double>;
  std::array<Dual, sight_size> row_a, row_b;
  write_sight(a, row_a);
  write_sight(b, row_b);
  row_b[0].rate = direction.x, row_b[1].rate = direction.y, row_b[2].rate = direction.z;
  return potential(sight_from<Dual>(row_a.data()), sight_from<Dual>(row_b.data())).rate;
}

template <class P>
double slope(const P& potential, double D, Random& random) {
  const auto [a, b] = random_sights_apart(D, random);
  const Vec3<double> r = b.p - a.p;
  return slope(potential, a, b, (1 / norm(r)) * r);
}

TEST(TooNear, InsideThePushIsOneDownToTheLastDecimetre) {
  Random random(1);
  for (int k = 0; k < 5000; ++k) {
    const TooNear near{.d_min = uniform(random, 0.8, 2)};
    EXPECT_NEAR(slope(near, uniform(random, 0.1, near.d_min - 0.6), random), -1, 0.02);
    EXPECT_NEAR(slope(near, near.d_min + uniform(random, 2, 50), random), 0, 1e-8);
  }
}

TEST(TooNear, TwoRobotsInOnePlaceArePushedApart) {
  Random random(2);
  for (int k = 0; k < 100; ++k) {
    Sight<double> a = random_sight(random, 3), b = random_sight(random, 3);
    b.p = a.p;
    EXPECT_GT(slope(TooNear{}, a, b, {1, 0, 0}), 0.6);  // b is cheaper at -x
  }
}

TEST(TooFar, OutsideThePullIsOneAtAnyDistance) {
  Random random(3);
  for (int k = 0; k < 5000; ++k) {
    const TooFar far{.d_max = uniform(random, 1, 3)};
    EXPECT_NEAR(slope(far, far.d_max + std::exp(uniform(random, 0, 14)), random), 1, 1e-3);
    EXPECT_NEAR(slope(far, uniform(random, 0.05, 0.3), random), 0, 2e-3);
  }
}

TEST(Slope, IsOnlyTheExcessInMetresAndRoundedNoMoreThanItSays) {
  Random random(4);
  for (int k = 0; k < 5000; ++k) {
    const double limit = uniform(random, 0.3, 2), D = uniform(random, 0.05, 5), kappa = 50;
    const auto [a, b] = random_sights_apart(D, random);
    const double bend = std::log(2.0) / kappa + 0.02;
    EXPECT_NEAR((TooNear{limit, kappa}(a, b)), std::fmax(limit - D, 0), bend);
    EXPECT_NEAR((TooFar{limit, kappa}(a, b)), std::fmax(D - limit, 0), bend);
    EXPECT_NEAR((TooNear{limit, kappa}.violation(a, b)), limit - D, 1e-13);
    EXPECT_NEAR((TooFar{limit, kappa}.violation(a, b)), D - limit, 1e-13);
  }
}

TEST(RelativeVelocity, IsTheSquareOfTheDifferenceAndFreeWhereBothMoveAlike) {
  Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const RelativeVelocity relative{.v_0 = uniform(random, 0.2, 3)};
    Sight<double> a = random_sight(random, 3), b = random_sight(random, 3);
    const double v = norm(a.v - b.v);
    EXPECT_NEAR(relative(a, b), square(v / relative.v_0), 1e-12 * (1 + square(v / relative.v_0)));
    const Vec3<double> shared = random_point(random, 1);
    const double l = relative(a, b);
    a.v = a.v + shared, b.v = b.v + shared;
    EXPECT_NEAR(relative(a, b), l, 1e-12 * (1 + l));
    b.v = a.v;
    EXPECT_EQ(relative(a, b), 0);
  }
}

}  // namespace
}  // namespace sightline
