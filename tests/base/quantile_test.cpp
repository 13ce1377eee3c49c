#include "sightline/base/quantile.hpp"

#include <gtest/gtest.h>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(Quantile, IsTheLeastThatItsShareDoesNotExceed) {
  Random random(1);
  for (int n = 1; n < 40; ++n) {
    std::vector<double> values;
    for (int i = 0; i < n; ++i) values.push_back(uniform(random, -1, 1));
    for (const double q : {0.0, 0.01, 0.3, 0.5, 0.99, 1.0}) {
      const double found = quantile(values, q);
      const auto up_to = std::count_if(values.begin(), values.end(), [&](double v) { return v <= found; });
      const auto below = std::count_if(values.begin(), values.end(), [&](double v) { return v < found; });
      EXPECT_GE(static_cast<double>(up_to), q * n);
      EXPECT_TRUE(below == 0 || static_cast<double>(below) < q * n);
    }
  }
}

TEST(Quantile, OfNothingIsNoNumber) { EXPECT_TRUE(std::isnan(quantile({}, 0.5))); }

TEST(Quantiles, OfAStreamAreThoseOfItsListWhileItIsShort) {
  Random random(2);
  Quantiles stream;
  std::vector<double> list;
  double sum = 0.0;
  for (std::size_t i = 0; i < 5000; ++i) {
    list.push_back(std::exp(uniform(random, -3, 9)));
    stream.add(list.back());
    sum += list.back();
  }
  for (const double q : {0.0, 0.1, 0.5, 0.99, 1.0}) EXPECT_EQ(stream.quantile(q), quantile(list, q));
  EXPECT_EQ(stream.mean(), sum / 5000);
  EXPECT_EQ(stream.greatest(), quantile(list, 1.0));
}

TEST(Quantiles, OfALongStreamAreWithinHalfAPercent) {
  Random random(3);
  Quantiles stream;
  std::vector<double> list;
  for (std::size_t i = 0; i < 3 * Quantiles::exact_max; ++i) {
    list.push_back(std::exp(uniform(random, -3, 9)));
    stream.add(list.back());
  }
  EXPECT_EQ(stream.count(), list.size());
  for (const double q : {0.001, 0.1, 0.5, 0.9, 0.99, 0.9999}) {
    const double exact = quantile(list, q);
    EXPECT_NEAR(stream.quantile(q), exact, 0.005 * exact) << q;
  }
  EXPECT_EQ(stream.greatest(), quantile(list, 1.0));
}

TEST(Quantiles, WhatIsOutOfTheirRangeCountsAsTheExtremes) {
  Quantiles stream;
  for (std::size_t i = 0; i < Quantiles::exact_max; ++i) stream.add(0.0);
  for (std::size_t i = 0; i < 2 * Quantiles::exact_max; ++i) stream.add(1e300);
  EXPECT_EQ(stream.quantile(0.2), 0.0);
  EXPECT_EQ(stream.quantile(0.5), 1e300);
  EXPECT_TRUE(std::isnan(Quantiles().mean()) && std::isnan(Quantiles().greatest()));
}

}  // namespace
}  // namespace sightline
