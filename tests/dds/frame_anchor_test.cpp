#include "bridges/dds/links/frame_anchor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline::dds {
namespace {

constexpr Nanoseconds tick = 10'000'000;

/// A robot at 1 m/s along x whose estimator is off by `off` since it counted `resets` jumps.
Motion published(int k, const Vec3<double>& off) {
  return {.p = Vec3<double>{0.01 * k, 0, 1} + off, .v = {1, 0, 0}};
}

TEST(FrameAnchor, AJumpThatIsCountedMovesTheFrameAndNotTheRobot) {
  FrameAnchor anchor;
  anchor.hold();
  int resets = 250;
  Vec3<double> off{};
  for (int k = 0; k < 1000; ++k) {
    if (k % 100 == 50) resets = (resets + 1) % 256, off = off + Vec3<double>{0.2, -0.1, 0.05};
    Motion m = published(k, off);
    anchor.follow(m, resets, k * tick);
    EXPECT_NEAR(m.p.x, 0.01 * k, 1e-9);
    EXPECT_NEAR(m.p.y, 0.0, 1e-9);
    EXPECT_NEAR(m.p.z, 1.0, 1e-9);
  }
  EXPECT_EQ(anchor.jumps(), 10);
  EXPECT_NEAR(anchor.moved(), 10 * norm(Vec3<double>{0.2, -0.1, 0.05}), 1e-9);
}

TEST(FrameAnchor, BeforeItHoldsAndWithoutACountAJumpIsBelieved) {
  FrameAnchor anchor;
  Motion m = published(0, {});
  anchor.follow(m, 0, tick);
  m = published(1, {5, 0, 0});
  anchor.follow(m, 1, 2 * tick);
  EXPECT_NEAR(m.p.x, 5.01, 1e-12);
  anchor.hold();
  m = published(2, {6, 0, 0});
  anchor.follow(m, 1, 3 * tick);
  EXPECT_NEAR(m.p.x, 6.02, 1e-12);
  EXPECT_EQ(anchor.jumps(), 0);
  EXPECT_EQ(anchor.moved(), 0.0);
}

}  // namespace
}  // namespace sightline::dds
