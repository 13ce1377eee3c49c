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

// A clock that is 3 s ahead of our real-time one, which is 1000 s ahead of the monotonic one; every
// tenth message is late.
TEST(LatencyMonitor, RateGapsAndDelaysAreThoseOfTheLastTenSeconds) {
  LatencyMonitor arrivals;
  Nanoseconds now = 0;
  for (int k = 0; k < 1500; ++k) {
    now = 10 * arrival_ms * k + (k % 10 == 9 ? 7 * arrival_ms : 2 * arrival_ms);
    arrivals.note(10 * arrival_ms * k + 1'003'000 * arrival_ms, now, (k % 10 == 9 ? 5 : 0) * arrival_ms);
  }
  const ArrivalFigures f = arrivals.figures(now, 1'000'000 * arrival_ms);
  EXPECT_NEAR(static_cast<double>(f.count), 1000, 2);
  EXPECT_NEAR(f.rate, 100.0, 0.2);
  EXPECT_NEAR(f.gap_longest, 0.015, 1e-9);
  EXPECT_EQ(f.age, 0.0);
  EXPECT_NEAR(f.delay_least, -2.998, 1e-6);
  EXPECT_NEAR(f.delay_median, -2.998, 1e-6);
  EXPECT_EQ(f.late_median, 0.0);
  EXPECT_NEAR(f.late_p99, 0.005, 1e-9);
  EXPECT_NEAR(arrivals.figures(now + 300 * arrival_ms, 0).gap_longest, 0.3, 1e-9);
  EXPECT_EQ(arrivals.figures(now + 20'000 * arrival_ms, 0).count, 0);
}

}  // namespace
}  // namespace sightline::dds
