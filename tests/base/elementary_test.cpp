#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "sightline/base.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The largest error of f against `exact` (long double) over n arguments that `draw` gives [ulp].
template <class F, class Exact, class Draw>
double worst_ulps(F f, Exact exact, Draw draw, int n = 200'000) {
  Random random(1);
  double worst = 0;
  for (int k = 0; k < n; ++k) {
    const double x = draw(random);
    worst = std::max(worst, ulps(f(x), exact(static_cast<long double>(x))));
  }
  return worst;
}

const auto sin_of = [](double x) { return sin(x); };
const auto cos_of = [](double x) { return cos(x); };
const auto exact_sin = [](long double x) { return std::sin(x); };
const auto exact_cos = [](long double x) { return std::cos(x); };

/// The same over numbers within `low` to `high`.
template <class F, class Exact>
double worst_within(F f, Exact exact, double low, double high) {
  return worst_ulps(f, exact, [&](Random& r) { return uniform(r, low, high); });
}

TEST(Elementary, ExpLogisticAndSoftplusAreWithinTheirUlpInAllBranches) {
  const auto exp_of = [](double x) { return exp(x); };
  const auto logistic_of = [](double x) { return logistic(x); };
  const auto softplus_of = [](double x) { return softplus(x); };
  const auto exact_exp = [](long double x) { return std::exp(x); };
  const auto exact_logistic = [](long double x) { return 1 / (1 + std::exp(-x)); };
  const auto exact_softplus = [](long double x) {
    return std::fmax(x, 0.0L) + std::log1p(std::exp(-std::fabs(x)));
  };
  EXPECT_LE(worst_within(exp_of, exact_exp, -708, 709), 1.5);
  EXPECT_LE(worst_within(exp_of, exact_exp, -1, 1), 1.5);
  for (const double reach : {1.0, 40.0, 700.0}) {
    EXPECT_LE(worst_within(logistic_of, exact_logistic, -reach, reach), 3.0) << reach;
    EXPECT_LE(worst_within(softplus_of, exact_softplus, -reach, reach), 4.0) << reach;
  }
}

TEST(Elementary, LogIsWithinTwoUlpAndRelaxedLogTooFromOneOn) {
  const auto log_of = [](double x) { return log(x); };
  const auto relaxed_of = [](double x) { return relaxed_log(x); };
  const auto exact = [](long double x) { return std::log(x); };
  EXPECT_LE(worst_within(log_of, exact, 0.5, 2), 2.0);
  EXPECT_LE(worst_within(log_of, exact, 0, 1e6), 2.0);
  EXPECT_LE(worst_ulps(log_of, exact, [](Random& r) { return std::exp(uniform(r, -708, 709)); }), 2.0);
  EXPECT_LE(worst_within(relaxed_of, exact, 1, 2), 2.0);
  EXPECT_LE(worst_ulps(relaxed_of, exact, [](Random& r) { return std::exp(uniform(r, 0, 709)); }), 2.0);
}

TEST(Elementary, RelaxedLogIsBelowOneTheParabolaThatTouchesTheLogarithm) {
  Random random(3);
  EXPECT_EQ(relaxed_log(1.0), 0.0);
  for (int k = 0; k < 200'000; ++k) {
    const double x = uniform(random, -1e3, 1);
    EXPECT_LE(ulps(relaxed_log(x), -(1 - x) - (1 - x) * static_cast<long double>(1 - x) / 2), 2.0) << x;
  }
  EXPECT_TRUE(std::isnan(relaxed_log(nan)));
}

TEST(Elementary, SinAndCosAreWithinTheirUlpUpToAMillion) {
  for (const double reach : {1.0, 10.0, 1e3, 1e6}) {
    EXPECT_LE(worst_within(sin_of, exact_sin, -reach, reach), 1.6) << reach;
    EXPECT_LE(worst_within(cos_of, exact_cos, -reach, reach), 1.6) << reach;
  }
}

TEST(Elementary, SinAndCosKeepTheirDigitsWhereTheyVanish) {
  const auto near_quarter = [](Random& r) {
    const double quarters = std::round(uniform(r, -6e5, 6e5));
    return quarters * (std::numbers::pi / 2) + uniform(r, -1e-9, 1e-9);
  };
  EXPECT_LE(worst_ulps(sin_of, exact_sin, near_quarter), 1.0);
  EXPECT_LE(worst_ulps(cos_of, exact_cos, near_quarter), 1.0);
}

TEST(Elementary, LogOfANegativeIsNotANumberAndOfZeroIsFinite) {
  EXPECT_TRUE(std::isnan(log(-1e-300)));
  EXPECT_TRUE(std::isnan(log(nan)));
  EXPECT_EQ(log(0.0), log(2.2250738585072014e-308));
  EXPECT_EQ(log(1.0), 0.0);
}

TEST(Elementary, Atan2IsWithinThreeUlpInEveryQuarter) {
  Random random(6);
  double worst = 0;
  for (int k = 0; k < 400'000; ++k) {
    const double reach = std::pow(10.0, uniform(random, -6, 6));
    const double y = uniform(random, -1, 1) * reach, x = uniform(random, -1, 1);
    worst = std::max(worst, ulps(atan2(y, x), std::atan2(static_cast<long double>(y), x)));
  }
  EXPECT_LE(worst, 3.0);
  EXPECT_EQ(atan2(0.0, 0.0), 0.0);
  EXPECT_EQ(atan2(0.0, 1.0), 0.0);
  EXPECT_EQ(atan2(0.0, -1.0), std::numbers::pi);
  EXPECT_EQ(atan2(-1.0, 0.0), -std::numbers::pi / 2);
}

TEST(Elementary, AnyFiniteArgumentGivesAFiniteResultInItsRange) {
  Random random(2);
  for (int k = 0; k < 200'000; ++k) {
    const double x = random_finite(random);
    EXPECT_TRUE(std::isfinite(exp(x)) && exp(x) > 0) << x;
    EXPECT_TRUE(logistic(x) > 0 && logistic(x) <= 1) << x;
    EXPECT_LE(std::fabs(sin(x)), 1.0) << x;
    EXPECT_LE(std::fabs(cos(x)), 1.0) << x;
    EXPECT_TRUE(std::isfinite(softplus(x)) && softplus(x) > 0) << x;
    EXPECT_TRUE(std::isfinite(log(std::fabs(x)))) << x;
    const double y = random_finite(random);
    EXPECT_LE(std::fabs(atan2(y, x)), std::numbers::pi) << y << ' ' << x;
  }
}

TEST(Elementary, NotANumberStaysNotANumber) {
  EXPECT_TRUE(std::isnan(exp(nan)));
  EXPECT_TRUE(std::isnan(logistic(nan)));
  EXPECT_TRUE(std::isnan(sin(nan)));
  EXPECT_TRUE(std::isnan(cos(nan)));
  EXPECT_TRUE(std::isnan(square(nan)));
  EXPECT_TRUE(std::isnan(softplus(nan)));
  EXPECT_TRUE(std::isnan(atan2(nan, 1.0)) && std::isnan(atan2(1.0, nan)));
}

TEST(Elementary, ExpIsHeldBeyondItsBounds) {
  for (const double x : {709.5, 1e4, 1e300, infinity}) EXPECT_EQ(exp(x), exp(709.0));
  for (const double x : {-708.5, -1e4, -1e300, -infinity}) EXPECT_EQ(exp(x), exp(-708.0));
}

TEST(Elementary, TheTwoSidesOfALogisticAddUpToOne) {
  Random random(3);
  for (int k = 0; k < 100'000; ++k) {
    const double x = uniform(random, -50, 50);
    EXPECT_NEAR(logistic(x) + logistic(-x), 1.0, 2.3e-16);
  }
  EXPECT_EQ(logistic(0.0), 0.5);
}

TEST(Elementary, SinIsOddCosIsEvenAndTheirSquaresAddUpToOne) {
  Random random(4);
  for (int k = 0; k < 100'000; ++k) {
    const double x = uniform(random, -1e4, 1e4);
    EXPECT_EQ(sin(-x), -sin(x));
    EXPECT_EQ(cos(-x), cos(x));
    EXPECT_NEAR(square(sin(x)) + square(cos(x)), 1.0, 5e-16);
  }
}

TEST(Elementary, TheBitsAreTheSameOnEveryMachineAndAtEveryOptimisationLevel) {
  constexpr std::uint64_t start = 14695981039346656037ull;  // FNV-1a over whole words
  std::uint64_t digest = start;
  const auto take = [&](double v) { digest = (digest ^ std::bit_cast<std::uint64_t>(v)) * 1099511628211ull; };
  for (int k = -5000; k <= 5000; ++k) {
    const double x = k * 0.1373;
    take(exp(x)), take(logistic(x)), take(sin(x)), take(cos(x));
  }
  EXPECT_EQ(digest, 8735741434214516763ull);
  digest = start;
  for (int k = -5000; k <= 5000; ++k) take(relaxed_log(k * 0.1373));
  EXPECT_EQ(digest, 3872154215374893434ull);
}

template <class L>
class ElementaryOnLanes : public testing::Test {};
using Widths = testing::Types<Lane<1>, Lane<2>, Lane<4>, Lane<8>>;
TYPED_TEST_SUITE(ElementaryOnLanes, Widths);

TYPED_TEST(ElementaryOnLanes, EachLaneHoldsTheBitsOfTheDouble) {
  constexpr int width = static_cast<int>(sizeof(TypeParam) / sizeof(double));
  Random random(5);
  for (int k = 0; k < 20'000; ++k) {
    std::array<double, width> row;
    for (double& x : row) {
      const double special[] = {nan, infinity, -infinity, -0.0};
      x = k % 3 == 0    ? random_finite(random)
          : k % 31 == 1 ? special[random() % 4]
                        : uniform(random, -800, 800);
    }
    const TypeParam x = TypeParam::load(row.data());
    const TypeParam e = exp(x), l = logistic(x), s = sin(x), c = cos(x), r = relaxed_log(x), p = softplus(x),
                    n = log(x), a = atan2(c, x);
    for (int i = 0; i < width; ++i) {
      ASSERT_TRUE(same_bits(e[i], exp(x[i]))) << x[i];
      ASSERT_TRUE(same_bits(l[i], logistic(x[i]))) << x[i];
      ASSERT_TRUE(same_bits(s[i], sin(x[i]))) << x[i];
      ASSERT_TRUE(same_bits(c[i], cos(x[i]))) << x[i];
      ASSERT_TRUE(same_bits(r[i], relaxed_log(x[i]))) << x[i];
      ASSERT_TRUE(same_bits(p[i], softplus(x[i]))) << x[i];
      ASSERT_TRUE(same_bits(n[i], log(x[i]))) << x[i];
      ASSERT_TRUE(same_bits(a[i], atan2(c[i], x[i]))) << x[i];
    }
  }
}

}  // namespace
}  // namespace sightline
