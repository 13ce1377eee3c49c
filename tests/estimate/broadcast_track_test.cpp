#include <gtest/gtest.h>

#include <algorithm>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// A body on a cubic in time, which turns evenly.
BroadcastPose on_cubic(double t) {
  BroadcastPose m{.stamp = t};
  m.p = {1 + t - 0.2 * t * t * t, 0.5 * t * t, -t};
  m.v = {1 - 0.6 * t * t, t, -1};
  m.psi = wrap(3.0 + 0.8 * t), m.yaw_rate = 0.8;
  m.P = identity<4>(1e-4);
  return m;
}

TEST(BroadcastTrack, BetweenTwoMessagesACubicIsExactAndTheHeadingGoesTheShortWay) {
  BroadcastTrack track;
  for (int k = 0; k < 20; ++k) track.take(on_cubic(0.1 * k));
  for (double t = 0.0; t < 1.9; t += 0.0137) {
    const std::optional<KnownPose> pose = track.at(t);
    ASSERT_TRUE(pose.has_value()) << t;
    EXPECT_LE(norm(pose->p - on_cubic(t).p), 1e-12);
    EXPECT_NEAR(wrap(pose->psi - on_cubic(t).psi), 0.0, 1e-12);
  }
}

TEST(BroadcastTrack, AfterTheLastMessageItGoesStraightOnWithGrowingDoubt) {
  BroadcastTrack track;
  track.take(on_cubic(1.0));
  double before = 1e-4;
  for (double d = 0.05; d < 0.3; d += 0.05) {
    const std::optional<KnownPose> pose = track.at(1.0 + d);
    ASSERT_TRUE(pose.has_value());
    EXPECT_LE(norm(pose->p - on_cubic(1.0).p - d * on_cubic(1.0).v), 1e-12);
    EXPECT_GT(pose->P(0, 0), before);
    before = pose->P(0, 0);
  }
  EXPECT_FALSE(track.at(1.31).has_value()) << "longer than the options allow";
  EXPECT_FALSE(track.at(0.9).has_value()) << "before the first message";
}

TEST(BroadcastTrack, AfterTheLastMessageItTurnsOnAndEachRateAddsItsUncertainty) {
  constexpr double d = 0.2;
  const auto later = [](double velocity_sigma, double turning) {
    BroadcastTrack track(
        {.acceleration = 0.0, .velocity_sigma = velocity_sigma, .turning = turning, .sighting_rate = 1e-3});
    track.take(on_cubic(1.0));
    return *track.at(1.0 + d);
  };
  const KnownPose exact = later(0.0, 0.0);
  EXPECT_NEAR(wrap(exact.psi - on_cubic(1.0 + d).psi), 0.0, 1e-12);
  EXPECT_EQ(exact.P, on_cubic(1.0).P);
  const KnownPose fast = later(0.1, 0.0), turning = later(0.0, 0.3);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(fast.P(i, i) - exact.P(i, i), square(0.1 * d), 1e-15);
  EXPECT_EQ(fast.P(3, 3), exact.P(3, 3));
  EXPECT_NEAR(turning.P(3, 3) - exact.P(3, 3), square(0.3 * d), 1e-15);
  EXPECT_EQ(turning.P(0, 0), exact.P(0, 0));
}

TEST(BroadcastTrack, SightingsThatShareAMessageShareItsError) {
  for (const double interval : {0.01, 0.1, 0.2}) {
    BroadcastTrack track(BroadcastOptions{.sighting_rate = 30.0});
    for (int k = 0; k < 5; ++k) track.take(on_cubic(interval * k));
    EXPECT_NEAR(track.at(2.5 * interval)->P(1, 1), 1e-4 * std::max(1.0, 30.0 * interval), 1e-12);
  }
}

TEST(BroadcastTrack, TheOrderInWhichMessagesArriveDoesNotMatter) {
  Random random(1);
  std::vector<BroadcastPose> messages;
  for (int k = 0; k < 40; ++k) messages.push_back(on_cubic(0.05 * k));
  BroadcastTrack in_order, shuffled;
  for (const BroadcastPose& m : messages) in_order.take(m);
  std::shuffle(messages.begin(), messages.end(), random);
  for (const BroadcastPose& m : messages) shuffled.take(m), shuffled.take(m);
  for (double t = 0.0; t < 2.1; t += 0.01) {
    EXPECT_EQ(in_order.at(t)->p.x, shuffled.at(t)->p.x);
    EXPECT_EQ(in_order.at(t)->P, shuffled.at(t)->P);
  }
}

TEST(BroadcastTrack, ItRemembersTheNewestMessages) {
  BroadcastTrack track;
  for (int k = 0; k < 500; ++k) track.take(on_cubic(0.01 * k));
  EXPECT_EQ(track.newest().stamp, 4.99);
  EXPECT_LE(norm(track.at(4.4)->p - on_cubic(4.4).p), 1e-12);
  EXPECT_FALSE(track.at(4.3).has_value());
  track.take(on_cubic(4.0));
  EXPECT_FALSE(track.at(4.0).has_value()) << "it is older than all that are remembered";
  track.forget();
  EXPECT_FALSE(track.is_known());
  EXPECT_FALSE(track.at(4.99).has_value());
}

TEST(BroadcastTrack, AMessageThatIsNotFiniteIsIgnored) {
  BroadcastTrack track;
  BroadcastPose bad = on_cubic(1.0);
  bad.p.y = not_a_number;
  track.take(bad);
  EXPECT_FALSE(track.is_known());
  EXPECT_EQ(refusal_of([] { return BroadcastTrack(BroadcastOptions{.longest = 0.0}); }),
            "broadcast.longest = 0, expected > 0 s");
}

}  // namespace
}  // namespace sightline
