#include "sightline/campaign/confidence.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

/// P(X >= k), X binomial, summed term by term.
double at_least(int k, int n, double p) {
  double sum = 0;
  for (int i = k; i <= n; ++i) {
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) + i * std::log(p) +
                    (n - i) * std::log1p(-p));
  }
  return sum;
}

TEST(Confidence, EachBoundIsWhereTheCountIsAsUnlikelyAsAllowed) {
  for (const int n : {1, 2, 10, 57, 300}) {
    for (int k = 0; k <= n; k += 1 + n / 10) {
      for (const double confidence : {0.9, 0.95, 0.999}) {
        const Interval bounds = clopper_pearson(k, n, confidence);
        const double tail = (1 - confidence) / 2;
        EXPECT_LE(bounds.low, static_cast<double>(k) / n);
        EXPECT_GE(bounds.high, static_cast<double>(k) / n);
        if (k > 0) {
          EXPECT_NEAR(at_least(k, n, bounds.low) / tail, 1.0, 1e-9);
        } else {
          EXPECT_EQ(bounds.low, 0.0);
        }
        if (k < n) {
          EXPECT_NEAR((1 - at_least(k + 1, n, bounds.high)) / tail, 1.0, 1e-7);
        } else {
          EXPECT_EQ(bounds.high, 1.0);
        }
      }
    }
  }
}

TEST(Confidence, OfRunsThatAllSucceededTheLowerBoundIsKnownInClosedForm) {
  for (const int n : {1, 30, 1000, 10'000, 1'000'000}) {
    EXPECT_NEAR(clopper_pearson(n, n).low, std::pow(0.025, 1.0 / n), 1e-12) << n;
    EXPECT_NEAR(clopper_pearson(0, n).high, 1 - std::pow(0.025, 1.0 / n), 1e-12) << n;
  }
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
