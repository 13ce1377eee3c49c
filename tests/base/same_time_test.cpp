#include <gtest/gtest.h>

#include <cmath>

#include "sightline/base.hpp"

namespace sightline {
namespace {

TEST(SameTime, IsMoreThanTheRoundingOfAMinuteOfStepsAndLessThanTheShortestPeriod) {
  constexpr double period = 1e-4;
  constexpr int steps = 600'000;
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) sum += period;
  EXPECT_LT(std::abs(sum - steps * period), same_time);
  EXPECT_LT(same_time, period);
}

}  // namespace
}  // namespace sightline
