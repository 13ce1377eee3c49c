#include "sightline/record/period_order.hpp"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(PeriodOrder, OnlyPeriodsThatTheLoopMissedMayBeMissing) {
  PeriodOrder order;
  EXPECT_TRUE(order.follows(0));
  EXPECT_TRUE(order.follows(1));
  order.miss(5, 1);
  order.miss(5, 2);
  EXPECT_TRUE(order.follows(5));
  EXPECT_FALSE(order.follows(7));
  EXPECT_EQ(order.next(), 8);
  EXPECT_TRUE(order.follows(8)) << "a gap is one once";
  order.miss(9, 1);
  EXPECT_FALSE(order.follows(9)) << "what was missed is there";
  EXPECT_FALSE(PeriodOrder().follows(1)) << "the first is missing";
}

}  // namespace
}  // namespace sightline
