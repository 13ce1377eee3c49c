#include "sightline/base/no_value.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline {
namespace {

TEST(NoValue, GivesWayToAnyFigureInFminAndFmax) {
  EXPECT_EQ(std::fmin(no_value, 1.0), 1.0);
  EXPECT_EQ(std::fmax(no_value, 1.0), 1.0);
  EXPECT_FALSE(std::isfinite(no_value));
}

}  // namespace
}  // namespace sightline
