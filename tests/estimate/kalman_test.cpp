#include "sightline/estimate/kalman.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/support/filter_derivatives.hpp"

namespace sightline {
namespace {

struct Drawn {
  Mat<6, 6> P;
  Innovation<3, 6> of;
};

Drawn draw(Random& random, double scale) {
  Drawn d;
  Mat<6, 6> B;
  for (auto& row : B.row)
    for (double& v : row) v = scale * uniform(random, -1, 1);
  d.P = B * transposed(B) + identity<6>(1e-3 * scale);
  for (int a = 0; a < 3; ++a) {
    d.of.y(a, 0) = uniform(random, -0.1, 0.1);
    for (int i = 0; i < 6; ++i) d.of.H(a, i) = i == a || i == 5 ? uniform(random, -2, 2) : 0.0;
    d.of.R(a, a) = uniform(random, 0.01, 0.2);
  }
  return d;
}

TEST(Kalman, TheUpdateIsThatOfTheInformationForm) {
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    Drawn d = draw(random, 0.5);
    const Mat<6, 6> before = d.P;
    Column<6> e;
    ASSERT_TRUE(update(d.P, d.of, e).accepted);
    // P'^-1 = P^-1 + H^T R^-1 H, e = P' H^T R^-1 y.
    const Mat<3, 6> weighed = Cholesky<3>(d.of.R).solve(d.of.H);
    const Mat<6, 6> information = Cholesky<6>(before).solve(identity<6>()) + transposed(d.of.H) * weighed;
    EXPECT_LE(test::greatest(information * d.P - identity<6>()), 1e-8);
    EXPECT_LE(test::greatest(e - d.P * (transposed(weighed) * d.of.y)), 1e-10);
  }
}

TEST(Kalman, TheCovarianceStaysSymmetricAndPositiveHoweverExactTheMeasurements) {
  Random random(2);
  Drawn d = draw(random, 100.0);
  for (int k = 0; k < 5000; ++k) {
    Drawn next = draw(random, 1.0);
    next.of.y = {};
    next.of.R = identity<3>(1e-10);
    Column<6> e;
    update(d.P, next.of, e);
    ASSERT_EQ(transposed(d.P), d.P);
    ASSERT_TRUE(Cholesky<6>(d.P + identity<6>(1e-14)).positive) << k;
    d.P = d.P + identity<6>(1e-12);
  }
}

TEST(Kalman, AMeasurementBeyondTheGateChangesNothing) {
  Random random(3);
  Drawn d = draw(random, 0.1);
  const Mat<6, 6> before = d.P;
  Column<6> e;
  d.of.y(0, 0) = 50.0;
  const Gated far = update(d.P, d.of, e);
  EXPECT_FALSE(far.accepted);
  EXPECT_GT(far.squared, chi_squared_gate<3>);
  d.of.y(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(update(d.P, d.of, e).accepted);
  d.of.y(0, 0) = 0.0;
  d.of.R = -1.0 * identity<3>();
  EXPECT_FALSE(update(d.P, d.of, e).accepted) << "a covariance that is none";
  EXPECT_EQ(d.P, before);
  EXPECT_EQ(e, Column<6>{});
}

template <int m>
double share_beyond(Random& random) {
  std::normal_distribution<double> normal;
  int beyond = 0;
  constexpr int draws = 400'000;
  for (int k = 0; k < draws; ++k) {
    double squared = 0.0;
    for (int i = 0; i < m; ++i) {
      const double n = normal(random);
      squared += n * n;
    }
    beyond += squared > chi_squared_gate<m>;
  }
  return beyond / double(draws);
}

TEST(Kalman, TheGateRefusesOneOfAThousandThatAreAsSupposed) {
  Random random(4);
  // 400 are expected, +- 20.
  EXPECT_NEAR(share_beyond<1>(random), 1e-3, 2e-4);
  EXPECT_NEAR(share_beyond<3>(random), 1e-3, 2e-4);
  EXPECT_NEAR(share_beyond<4>(random), 1e-3, 2e-4);
}

}  // namespace
}  // namespace sightline
