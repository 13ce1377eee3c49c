#include "bridges/dds/topics/delay_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace sightline::dds {
namespace {

TEST(DelayHistogram, QuantilesAreThoseOfTheTimesRoundedUp) {
  std::mt19937_64 random(5);
  std::lognormal_distribution<> delay(-7, 1.5);  // [s]
  DelayHistogram histogram;
  std::vector<double> times;
  for (int i = 0; i < 20'000; ++i) histogram.add(times.emplace_back(std::max(1e-6, delay(random))));
  std::sort(times.begin(), times.end());
  EXPECT_EQ(histogram.count(), 20'000);
  for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const double exact = times[static_cast<std::size_t>(std::ceil(share * 20'000)) - 1];
    EXPECT_GE(histogram.within(share), exact * (1 - 1e-12)) << share;
    EXPECT_LE(histogram.within(share), 1.033 * exact) << share;
  }
}

TEST(DelayHistogram, WhatIsBeyondItsRangeCountsAsItsEdgesAndWhatIsNoNumberNot) {
  DelayHistogram histogram, all;
  EXPECT_EQ(histogram.within(0.5), 0.0);
  histogram.add(-1.0), histogram.add(0.0), histogram.add(1e9);
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(histogram.count(), 3);
  EXPECT_LE(histogram.within(0.5), 1.04e-6);
  EXPECT_NEAR(histogram.within(1.0), 134.2, 0.1);
  all.add(histogram), all.add(histogram);
  EXPECT_EQ(all.count(), 6);
}

}  // namespace
}  // namespace sightline::dds
