#include <gtest/gtest.h>

#include "sightline/base.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// D [m] apart in a random direction.
std::pair<Sight<double>, Sight<double>> random_sights_apart(double D, Random& random) {
  const Sight<double> a = random_sight(random, 3);
  Sight<double> b = random_sight(random, 3);
  const Vec3<double> r = b.p - a.p;
  b.p = a.p + (D / norm(r)) * r;
  return {a, b};
}

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
