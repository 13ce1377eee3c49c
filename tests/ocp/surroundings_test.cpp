#include <gtest/gtest.h>

#include "sightline/events.hpp"

namespace sightline {
namespace {

TEST(Surroundings, AChangeIsBlendedFromRestToRest) {
  EXPECT_EQ(blended(0.9, 1.0, 2.0), 0.0);
  EXPECT_EQ(blended(2.0, 1.0, 2.0), 0.5);
  EXPECT_EQ(blended(3.0, 1.0, 2.0), 1.0);
  EXPECT_EQ(blended(9.0, 1.0, 2.0), 1.0);
  EXPECT_LT(blended(1.01, 1.0, 2.0), 1e-4);
  EXPECT_GT(blended(2.99, 1.0, 2.0), 1 - 1e-4);
  EXPECT_EQ(blended(0.9, 1.0, 0.0), 0.0);
  EXPECT_EQ(blended(1.0, 1.0, 0.0), 1.0);
}

}  // namespace
}  // namespace sightline
