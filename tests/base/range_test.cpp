#include "sightline/base/range.hpp"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Range, ZeroIsNotNegativeAndNotPositive) {
  const auto takes = [](const Range& range, double x) { return x >= range.low && x <= range.high; };
  EXPECT_TRUE(takes(not_negative(">= 0"), 0.0));
  EXPECT_FALSE(takes(positive("> 0"), 0.0));
  EXPECT_TRUE(takes(positive("> 0"), 1e-300));
  EXPECT_TRUE(takes(any_number(), -largest_number));
  EXPECT_FALSE(takes(any_number(), std::nextafter(largest_number, 2e9)));
}

TEST(Range, AtLeastZeroIsFinite) {
  EXPECT_TRUE(at_least_zero(0.0) && at_least_zero(1e9));
  EXPECT_FALSE(at_least_zero(-1e-300));
  EXPECT_FALSE(at_least_zero(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(at_least_zero(std::numeric_limits<double>::infinity()));
}

}  // namespace
}  // namespace sightline
