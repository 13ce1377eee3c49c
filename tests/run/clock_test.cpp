#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "sightline/base/now.hpp"
#include "sightline/loop.hpp"

namespace sightline {
namespace {

using Time = std::chrono::steady_clock;
using std::chrono::milliseconds;

TEST(SteadyClock, NoPeriodBeginsBeforeItsTime) {
  SteadyClock clock;
  EXPECT_FALSE(clock.waits_for_log());
  const Time::time_point start = Time::now();
  clock.start(0.002);
  for (std::int64_t k = 0; k < 20; ++k) {
    const std::int64_t now = clock.wait(k);
    EXPECT_GE(now, k);
    EXPECT_GE(Time::now() - start, milliseconds(2) * now);
    k = now;
  }
}

TEST(SteadyClock, PeriodsThatAreOverAreMissedAndNotMadeUpFor) {
  SteadyClock clock;
  clock.start(0.005);
  std::this_thread::sleep_for(milliseconds(31));
  const std::int64_t now = clock.wait(1);
  EXPECT_GE(now, 5);  // 1 to 4 are over
  EXPECT_GT(clock.wait(now + 1), now);
}

TEST(SteadyClock, ALatePeriodDoesNotMoveTheGrid) {
  const Time::time_point start = Time::now();
  SteadyClock clock;
  clock.start(0.02);
  std::this_thread::sleep_for(milliseconds(31));
  std::int64_t k = clock.wait(1) + 1;
  k = clock.wait(k);
  // It begins on a multiple of the period after the start, or later, never on one after the late
  // wake-up.
  EXPECT_GE(Time::now() - start, milliseconds(20) * k);
  EXPECT_GE(k, 2);
}

TEST(SteadyClock, PeriodsBeginWhereThoseOfOtherProgramsDo) {
  constexpr std::int64_t period = 5'000'000;  // [ns]
  for (const int later : {0, 1, 3}) {
    std::this_thread::sleep_for(milliseconds(later));
    SteadyClock clock;
    clock.start(1e-9 * period);
    std::int64_t earliest = period;  // that one of them begins behind a multiple
    for (std::int64_t k = 0; k < 20; ++k) {
      k = clock.wait(k);
      earliest = std::min(earliest, monotonic_now() % period);
    }
    EXPECT_LT(earliest, period / 4) << later;
  }
}

}  // namespace
}  // namespace sightline
