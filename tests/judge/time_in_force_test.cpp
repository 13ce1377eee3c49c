#include "sightline/judge/time_in_force.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

TEST(TimeInForce, SaysFromWhenToWhenAndHowLongInAll) {
  TimeInForce time;
  for (int k = 200; k < 400; ++k) time.count(0.01 * k, 0.01);
  for (int k = 500; k < 600; ++k) time.count(0.01 * k, 0.01);
  EXPECT_EQ(time_words(time.json()), "3.0 s, 2.0 to 6.0 s");
  EXPECT_FALSE(time.is_whole(6.0));
}

TEST(TimeInForce, IsWholeWhereNoPeriodIsMissingHoweverManyThereAre) {
  TimeInForce time;
  const int periods = 360'000;
  for (int k = 0; k < periods; ++k) time.count(0.01 * k, 0.01);
  EXPECT_TRUE(time.is_whole(0.01 * periods));
  EXPECT_FALSE(time.is_whole(0.01 * (periods + 1)));
}

TEST(TimeInForce, IsNotWholeWhereNothingCounted) { EXPECT_FALSE(TimeInForce{}.is_whole(1.0)); }

}  // namespace
}  // namespace sightline
