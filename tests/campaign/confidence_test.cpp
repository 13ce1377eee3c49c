#include "sightline/campaign/confidence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace sightline {
namespace {

TEST(Wilson, IsWhatItsFormulaSaysAndHoldsTheShare) {
  const Interval of_81 = wilson(81, 263);  // Newcombe 1998, Table I
  EXPECT_NEAR(of_81.low, 0.2553, 5e-5);
  EXPECT_NEAR(of_81.high, 0.3662, 5e-5);
  const Interval of_15 = wilson(15, 148);
  EXPECT_NEAR(of_15.low, 0.0624, 5e-5);
  EXPECT_NEAR(of_15.high, 0.1605, 5e-5);
  const Interval none = wilson(0, 20);
  EXPECT_EQ(none.low, 0.0);
  EXPECT_NEAR(none.high, 0.1611, 5e-5);
  EXPECT_EQ(wilson(29, 29).high, 1.0);
  for (std::int64_t good = 0; good <= 50; ++good) {
    const Interval one = wilson(good, 50), other = wilson(50 - good, 50);
    EXPECT_LE(one.low, static_cast<double>(good) / 50);
    EXPECT_GE(one.high, static_cast<double>(good) / 50);
    EXPECT_NEAR(one.low, 1 - other.high, 1e-12);
  }
}

TEST(Wilson, HoldsTheProbabilityAboutAsOftenAsItSays) {
  for (const double p : {0.1, 0.5, 0.9}) {
    const int n = 60;
    double covered = 0.0;
    for (int k = 0; k <= n; ++k) {
      const Interval bounds = wilson(k, n);
      if (p < bounds.low || p > bounds.high) continue;
      covered += std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) + k * std::log(p) +
                          (n - k) * std::log(1 - p));
    }
    EXPECT_NEAR(covered, 0.95, 0.03) << p;
  }
}

TEST(ClopperPearson, IsWhatItsFormulaSaysAndNeverHoldsLessOftenThanItSays) {
  EXPECT_NEAR(clopper_pearson(0, 200).high, 1 - std::pow(0.025, 1.0 / 200), 1e-12);
  EXPECT_EQ(clopper_pearson(0, 200).low, 0.0);
  EXPECT_EQ(clopper_pearson(200, 200).high, 1.0);
  for (const double p : {0.01, 0.1, 0.5}) {
    const int n = 60;
    double below = 0.0, above = 0.0;  // probability that the bounds miss p
    for (int k = 0; k <= n; ++k) {
      const Interval bounds = clopper_pearson(k, n);
      const double of_k = std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) +
                                   k * std::log(p) + (n - k) * std::log(1 - p));
      if (bounds.high < p) below += of_k;
      if (bounds.low > p) above += of_k;
    }
    EXPECT_LE(below, 0.025) << p;
    EXPECT_LE(above, 0.025) << p;
  }
}

TEST(NormalQuantile, IsTheInverseOfTheDistribution) {
  for (const double z : {-6.0, -2.5, -0.1, 0.0, 1.0, 4.0}) {
    EXPECT_NEAR(normal_probability(z), std::erfc(-z / std::sqrt(2.0)) / 2, 1e-15) << z;
    EXPECT_NEAR(normal_quantile(normal_probability(z)), z, 1e-6) << z;
  }
}

TEST(BootstrapMedian, HoldsTheMedianAboutAsOftenAsItSaysAndIsTheSameEachTime) {
  std::mt19937_64 random(7);
  std::exponential_distribution<double> waits(1.0);
  int covered = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<double> values(41);
    for (double& value : values) value = waits(random);
    const MedianBounds bounds = bootstrap_median(values, 0.95, 400);
    std::reverse(values.begin(), values.end());
    EXPECT_EQ(bootstrap_median(values, 0.95, 400).low, bounds.low);
    EXPECT_LE(bounds.low, bounds.median);
    EXPECT_LE(bounds.median, bounds.high);
    if (bounds.low <= std::log(2.0) && std::log(2.0) <= bounds.high) ++covered;
  }
  EXPECT_NEAR(covered / 300.0, 0.95, 0.05);
  EXPECT_EQ(bootstrap_median({4.0}).low, 4.0);
  EXPECT_EQ(bootstrap_median({1.0, 3.0}).median, 2.0);
  EXPECT_EQ(bootstrap_median({4.0, 1.0, 2.0, 2.5}).median, 2.25);
  EXPECT_EQ(bootstrap_median({9.0, 5.0, 1.0}).median, 5.0);
}

TEST(SignTest, IsTheBinomialOfOneHalf) {
  EXPECT_EQ(sign_test(0, 0), 1.0);
  EXPECT_EQ(sign_test(4, 4), 1.0);
  EXPECT_NEAR(sign_test(0, 5), 2.0 / 32, 1e-12);
  EXPECT_NEAR(sign_test(1, 9), 2.0 * 11 / 1024, 1e-12);
  EXPECT_EQ(sign_test(3, 12), sign_test(12, 3));
}

TEST(Confidence, TheIncompleteBetaFunctionIsItsIntegral) {
  for (const double a : {0.5, 1.0, 3.0, 40.0}) {
    for (const double b : {1.0, 2.5, 60.0}) {
      for (const double x : {0.0, 0.1, 0.4, 0.77, 1.0}) {
        // Simpson's rule over t^2 = s, which is smooth at 0.
        constexpr int steps = 20'000;
        double sum = 0;
        for (int i = 0; i <= steps; ++i) {
          const double s = std::sqrt(x) * i / steps;
          const double f = 2 * std::pow(s, 2 * a - 1) * std::pow(1 - s * s, b - 1);
          sum += f * (i == 0 || i == steps ? 1 : i % 2 == 1 ? 4 : 2);
        }
        const double beta = std::exp(std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b));
        EXPECT_NEAR(incomplete_beta(a, b, x), sum * std::sqrt(x) / steps / 3 / beta, 1e-7)
            << a << " " << b << " " << x;
        EXPECT_NEAR(incomplete_beta(a, b, x), 1 - incomplete_beta(b, a, 1 - x), 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace sightline
