#include "bridges/dds/topics/remote_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "tests/dds/time_units.hpp"

namespace sightline::dds {
namespace {

using Stamp = RemoteClock::Stamp;

constexpr Nanoseconds hour = 3600 * second;

/// Remote time at local time t: t + offset + drift t.
Nanoseconds remote(Nanoseconds t, double drift, Nanoseconds offset = hour) {
  return t + offset + std::llround(drift * static_cast<double>(t));
}

// Messages take 1 ms, and some 5 ms more.
TEST(RemoteClock, AConstantOffsetIsRemoved) {
  RemoteClock clock;
  for (std::int64_t k = 1; k < 3000; ++k) {
    const Nanoseconds sent = k * 10 * ms, late = k % 7 == 3 ? 5 * ms : 0;
    ASSERT_EQ(clock.take(sent + hour, sent + ms + late), Stamp::good);
    ASSERT_EQ(clock.on_ours(), sent + ms) << k;  // all but the least delay
  }
  EXPECT_EQ(clock.offset(), ms - hour);
  EXPECT_EQ(clock.jumps(), 0);
}

TEST(RemoteClock, ADriftIsFollowed) {
  for (const double drift : {-0.045, -0.007, -1e-4, 0.0, 1e-4, 0.007, 0.045}) {
    std::mt19937 random(7);
    std::exponential_distribution<double> more(1.0 / 0.5e6);  // mean 0.5 ms
    RemoteClock clock;
    for (std::int64_t k = 1; k < 3000; ++k) {
      const Nanoseconds sent = k * 10 * ms, delay = ms + std::llround(more(random));
      ASSERT_EQ(clock.take(remote(sent, drift), sent + delay), Stamp::good) << drift << ", " << k;
      ASSERT_LE(clock.on_ours(), sent + delay);
      if (sent < 3 * second) continue;
      ASSERT_NEAR(static_cast<double>(clock.on_ours() - sent), 1e6, 0.5e6) << drift << ", " << k;
      ASSERT_NEAR(clock.drift(), -drift, 5e-4) << k;
    }
    EXPECT_EQ(clock.jumps(), 0) << drift;
  }
}

// A queue on the way: messages of half a second come at once.
TEST(RemoteClock, MessagesHeldUpOnTheWayAreNoJump) {
  RemoteClock clock;
  for (std::int64_t k = 1; k < 2000; ++k) {
    const Nanoseconds sent = k * 10 * ms;
    const std::int64_t in_second = k % 300;
    const Nanoseconds arrival =
        in_second < 50 && k > 300 ? (k - in_second + 50) * 10 * ms + in_second : sent + ms;
    ASSERT_EQ(clock.take(sent + hour, arrival), Stamp::good) << k;
    ASSERT_NEAR(static_cast<double>(clock.on_ours() - sent), 1e6, 0.2e6) << k;
  }
  EXPECT_EQ(clock.jumps(), 0);
}

// Also over a link that delivers each message twice.
TEST(RemoteClock, AJumpIsFollowedFromTheThirdMessage) {
  for (const Nanoseconds jump :
       {-hour, -2 * second, -100 * ms, -30 * ms, 30 * ms, 100 * ms, 2 * second, hour}) {
    for (const bool twice : {false, true}) {
      RemoteClock clock;
      for (std::int64_t k = 1; k < 1000; ++k) {
        const Nanoseconds sent = k * 10 * ms;
        const bool after = k >= 500;
        const Nanoseconds stamp = sent + 2 * hour + (after ? jump : 0);
        const bool good = clock.take(stamp, sent + ms) == Stamp::good;
        EXPECT_EQ(good, k != 500 && k != 501) << jump << ", " << k;
        if (good) {
          EXPECT_EQ(clock.on_ours(), sent + ms) << jump << ", " << k;
        }
        if (twice) {
          EXPECT_NE(clock.take(stamp, sent + 2 * ms), Stamp::good) << jump << ", " << k;
        }
      }
      EXPECT_EQ(clock.jumps(), 1) << jump;
    }
  }
}

// Repeated, out of order, or forged: up to 1 h off.
TEST(RemoteClock, SingleBadStampsChangeNothing) {
  RemoteClock clock;
  for (std::int64_t k = 1; k < 1000; ++k) {
    const Nanoseconds sent = k * 10 * ms;
    ASSERT_EQ(clock.take(sent + hour, sent + ms), Stamp::good) << k;
    ASSERT_EQ(clock.on_ours(), sent + ms) << k;
    if (k % 5 == 0) {
      EXPECT_EQ(clock.take(sent + hour, sent + 2 * ms), Stamp::repeated);
    }
    if (k % 7 == 0) {
      EXPECT_EQ(clock.take(sent + hour - 25 * ms, sent + 3 * ms), Stamp::repeated);
    }
    if (k % 11 == 0) {
      EXPECT_EQ(clock.take(sent + 2 * hour, sent + 4 * ms), Stamp::ahead);
    }
    if (k % 13 == 0) {
      EXPECT_EQ(clock.take(0, sent + 5 * ms), Stamp::repeated);
    }
  }
  EXPECT_EQ(clock.jumps(), 0);
}

// Stamps of PX4's own simulation: its clock is 7 ms a second slow, and its time sync sets it right
// by 0.1 s.
TEST(RemoteClock, OfASlowSimulationThatIsSetRightNowAndThenStampsAreRight) {
  RemoteClock clock;
  Nanoseconds slow = 0;
  int bad = 0, wrong = 0;
  for (std::int64_t k = 1; k < 6000; ++k) {
    const Nanoseconds sent = k * 10 * ms;
    slow += 70'000;
    if (slow > 100 * ms) slow = 0;
    if (clock.take(sent + hour - slow, sent + ms) != Stamp::good)
      ++bad;
    else if (std::abs(clock.on_ours() - sent - ms) > 2 * ms)
      ++wrong;
  }
  EXPECT_EQ(clock.jumps(), 4);
  EXPECT_EQ(bad, 2 * 4);
  EXPECT_LT(wrong, 250);  // before the drift is known
}

}  // namespace
}  // namespace sightline::dds
