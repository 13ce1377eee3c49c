#include "bridges/dds/topics/latency_monitor.hpp"

#include <gtest/gtest.h>

namespace sightline::dds {
namespace {

constexpr Nanoseconds arrival_ms = 1'000'000;

TEST(LatencyMonitor, OfNoneAllIsZero) {
  const ArrivalFigures none = LatencyMonitor().figures(5, 7);
  EXPECT_EQ(none.count, 0);
  EXPECT_EQ(none.rate, 0.0);
}

// A clock that is 3 s ahead of our real-time one, which is 1000 s ahead of the monotonic one; every tenth message is late.
TEST(LatencyMonitor, RateGapsAndDelaysAreThoseOfTheLastTenSeconds) {
  LatencyMonitor arrivals;
  Nanoseconds now = 0;
  for (int k = 0; k < 1500; ++k) {
    now = 10 * arrival_ms * k + (k % 10 == 9 ? 7 * arrival_ms : 2 * arrival_ms);
    arrivals.note(10 * arrival_ms * k + 1'003'000 * arrival_ms, now);
  }
  const ArrivalFigures f = arrivals.figures(now, 1'000'000 * arrival_ms);
  EXPECT_NEAR(static_cast<double>(f.count), 1000, 2);
  EXPECT_NEAR(f.rate, 100.0, 0.2);
  EXPECT_NEAR(f.gap_longest, 0.015, 1e-9);
  EXPECT_EQ(f.age, 0.0);
  EXPECT_NEAR(f.delay_least, -2.998, 1e-6);
  EXPECT_NEAR(f.delay_median, -2.998, 1e-6);
  EXPECT_NEAR(f.delay_p99, -2.993, 1e-6);
  EXPECT_NEAR(f.drift, 0.0, 1e-9);
  EXPECT_NEAR(arrivals.figures(now + 300 * arrival_ms, 0).gap_longest, 0.3, 1e-9);
  EXPECT_EQ(arrivals.figures(now + 20'000 * arrival_ms, 0).count, 0);
}

TEST(LatencyMonitor, AClockThatRunsFasterDrifts) {
  LatencyMonitor arrivals;
  for (int k = 0; k < 800; ++k)
    arrivals.note(10 * arrival_ms * k + 10 * arrival_ms * k / 500, 10 * arrival_ms * k + arrival_ms);
  EXPECT_NEAR(arrivals.figures(8000 * arrival_ms, 0).drift, -0.002, 2e-5);
}

}  // namespace
}  // namespace sightline::dds
