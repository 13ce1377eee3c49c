#include <gtest/gtest.h>

#include "sightline/base.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

Sight<double> looking(const Vec3<double>& p, double heading) {
  return {{p, {std::cos(heading), std::sin(heading)}}, {}};
}

/// -dl/dp_a along a direction: how a is pushed.
double push(const PassRight& potential, const Sight<double>& a, const Sight<double>& b,
            const Vec3<double>& direction) {
  using Dual = Tangent<double>;
  std::array<Dual, sight_size> row_a, row_b;
  write_sight(a, row_a);
  write_sight(b, row_b);
  row_a[0].rate = direction.x, row_a[1].rate = direction.y, row_a[2].rate = direction.z;
  return -potential(sight_from<Dual>(row_a.data()), sight_from<Dual>(row_b.data())).rate;
}

PassRight random_parameters(Random& random) {
  const double d_min = uniform(random, 0.5, 2.0);
  return {.d_min = d_min, .delta = uniform(random, 0.05, 0.5) * d_min, .kappa = uniform(random, 5.0, 20.0)};
}

TEST(PassRight, HeadOnBothArePushedToTheirRight) {
  Random random(1);
  for (int k = 0; k < 2000; ++k) {
    const PassRight pass = random_parameters(random);
    const double psi = uniform(random, -3.1, 3.1), D = uniform(random, 0.2, 1.0) * pass.d_min;
    const Vec3<double> ahead = {std::cos(psi), std::sin(psi), 0.0}, right = {ahead.y, -ahead.x, 0.0};
    const Sight<double> a = looking(random_point(random, 5), psi),
                        b = looking(a.p + D * ahead, psi + std::numbers::pi);
    EXPECT_GT(push(pass, a, b, right), 0.0);
    EXPECT_GT(push(pass, b, a, -1.0 * right), 0.0);
    EXPECT_LT(push(pass, a, b, ahead), 0.0);
  }
}

TEST(PassRight, WhereWaysCrossTheOneFromTheRightIsHeldUpLess) {
  Random random(2);
  for (int k = 0; k < 2000; ++k) {
    const PassRight pass = random_parameters(random);
    const double psi = uniform(random, -3.1, 3.1), D = uniform(random, 0.5, 0.9) * pass.d_min;
    const Vec3<double> ahead = {std::cos(psi), std::sin(psi), 0.0}, right = {ahead.y, -ahead.x, 0.0};
    // b comes from the right of a; both are as far from where they would meet.
    const Vec3<double> meet = random_point(random, 5);
    const double way = D / std::sqrt(2.0);
    const Sight<double> a = looking(meet - way * ahead, psi),
                        b = looking(meet + way * right, psi + std::numbers::pi / 2);
    EXPECT_LT(push(pass, a, b, ahead), push(pass, b, a, -1.0 * right));
  }
}

TEST(PassRight, RobotsThatLookOneWayFeelTooNearAndWithoutDeltaAllDo) {
  Random random(3);
  for (int k = 0; k < 2000; ++k) {
    PassRight pass = random_parameters(random);
    const TooNear near{.d_min = pass.d_min, .kappa = pass.kappa};
    Sight<double> a = random_sight(random, 1), b = random_sight(random, 1);
    if (k % 2 == 0)
      b.d = a.d;
    else
      pass.delta = 0.0;
    EXPECT_NEAR(pass(a, b), near(a, b), 1e-12);
    EXPECT_NEAR(pass.violation(a, b), near.violation(a, b), 1e-12);
  }
}

TEST(PassRight, OnTheRightTheyPassDeltaNearerThanOnTheLeft) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const PassRight pass = random_parameters(random);
    const double psi = uniform(random, -3.1, 3.1);
    const Vec3<double> left = {-std::sin(psi), std::cos(psi), 0.0};
    const Sight<double> a = looking(random_point(random, 5), psi);
    const auto other = [&](double to_the_left) {
      return looking(a.p + to_the_left * left, psi + std::numbers::pi);
    };
    EXPECT_NEAR(pass.violation(a, other(pass.d_min - pass.delta)), 0.0, 1e-12);
    EXPECT_NEAR(pass.violation(a, other(-(pass.d_min + pass.delta))), 0.0, 1e-12);
  }
}

TEST(PassRight, OnlyDifferencesCountAndEachHasTheOtherOnTheSameSide) {
  Random random(5);
  for (int k = 0; k < 2000; ++k) {
    const PassRight pass = random_parameters(random);
    const Sight<double> a = random_sight(random, 1), b = random_sight(random, 1);
    EXPECT_NEAR(pass(a, b), pass(b, a), 0.03);  // but for the slope that parts two in one place
    EXPECT_NEAR(pass.violation(a, b), pass.violation(b, a), 1e-12);
    Sight<double> moved_a = a, moved_b = b;
    const Vec3<double> way = random_point(random, 3);
    moved_a.p = a.p + way, moved_b.p = b.p + way;
    EXPECT_NEAR(pass(moved_a, moved_b), pass(a, b), 1e-11);
  }
}

TEST(PassRight, AnOffsetAsLargeAsTheDistanceIsRefused) {
  EXPECT_EQ(refusal_of([] { PassRight{.d_min = 0.5, .delta = 0.5}.check(); }),
            "pass_right.delta = 0.5, expected 0 m to below d_min");
}

}  // namespace
}  // namespace sightline
