#include "bridges/dds/topics/pose_subscriber.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/dds/time_units.hpp"

namespace sightline::dds {
namespace {

TEST(PoseSubscriber, TheNewestMotionIsSeenInTheTeamsFrameAndByOurClock) {
  PoseSubscriber poses({{1, 2, 3}, std::numbers::pi / 2});
  SeenMotion seen;
  EXPECT_FALSE(poses.look(seen));
  EXPECT_FALSE(poses.is_fresh(0, second));
  for (int k = 0; k < 3; ++k)
    poses.take({{0.1 * k, 0, 0}, upright({1, 0}), {1, 0, 0}, 0.5}, 500 * second + 10 * k * ms,
               second + 10 * k * ms);
  ASSERT_TRUE(poses.look(seen));
  EXPECT_NEAR(seen.motion.p.x, 1.0, 1e-12);
  EXPECT_NEAR(seen.motion.p.y, 2.2, 1e-12);
  EXPECT_NEAR(seen.motion.v.y, 1.0, 1e-12);
  EXPECT_EQ(seen.motion.r, 0.5);
  EXPECT_EQ(seen.stamp, second + 20 * ms);
  EXPECT_EQ(poses.clock_offset(), -499 * second);
  EXPECT_TRUE(poses.is_fresh(second + 100 * ms, 100 * ms));
  EXPECT_FALSE(poses.is_fresh(second + 120 * ms, 100 * ms));
}

// The sender's clock is 499 s ahead and jumps by 2 s: delays are counted by the followed clock.
TEST(PoseSubscriber, ThePosesLatenessIsThatBeyondTheFastest) {
  PoseSubscriber poses;
  const Motion at_rest = {{0, 0, 0}, upright({1, 0}), {}, 0};
  constexpr int count = 200;
  for (int k = 0; k < count; ++k) {
    const Nanoseconds sent = second + 10 * k * ms, ahead = (k < count / 2 ? 499 : 501) * second,
                      late = k % 10 == 9 ? 8 * ms : 0;
    poses.take(at_rest, sent + ahead, sent + 3 * ms + late);
    if (k < 20) poses.take(at_rest, sent + ahead, sent + 4 * ms + late);  // repeated, not counted
  }
  EXPECT_EQ(poses.clock_jumps(), 1);
  const DelayHistogram& lateness = poses.lateness();
  EXPECT_NEAR(static_cast<double>(lateness.count()), count, 3);  // until the jump is certain
  EXPECT_LE(lateness.within(0.85), 2e-6);
  EXPECT_NEAR(lateness.within(0.95), 0.008, 0.0004);
  EXPECT_NEAR(lateness.within(1.0), 0.008, 0.0004);
}

TEST(PoseSubscriber, WhatIsNotFiniteOrOfAnotherTimeIsCountedAndNotSeen) {
  PoseSubscriber poses;
  const Motion good = {{1, 0, 0}, upright({1, 0}), {}, 0};
  Motion bad = good;
  bad.p.y = std::numeric_limits<double>::quiet_NaN();
  poses.take(bad, second, second);
  bad = good;
  bad.q = no_attitude;
  poses.take(bad, second, second);
  SeenMotion seen;
  EXPECT_FALSE(poses.look(seen));
  poses.take(good, second, second);
  poses.take({{2, 0, 0}, good.q, {}, 0}, 10 * second, second + 10 * ms);
  poses.take_other_frame();
  ASSERT_TRUE(poses.look(seen));
  EXPECT_EQ(seen.motion.p.x, 1.0);
  EXPECT_TRUE(poses.in_other_frames());
}

}  // namespace
}  // namespace sightline::dds
