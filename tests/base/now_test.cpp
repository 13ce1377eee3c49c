#include "sightline/base/now.hpp"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Now, TheNextMultipleIsTheFirstThatIsNotBefore) {
  for (const std::int64_t period : {1, 3, 10})
    for (std::int64_t t = 0; t < 40; ++t) {
      const std::int64_t next = next_multiple(t, period);
      EXPECT_EQ(next % period, 0) << t << " of " << period;
      EXPECT_GE(next, t) << t << " of " << period;
      EXPECT_LT(next, t + period) << t << " of " << period;
    }
}

TEST(Now, SleepEndsNoEarlierThanAsked) {
  const std::int64_t until = monotonic_now() + 3'000'000;
  sleep_until(until);
  EXPECT_GE(monotonic_now(), until);
  sleep_until(until - 1'000'000'000);  // long over
}

TEST(Now, RealTimeIsThatOfThisCentury) { EXPECT_GT(realtime_now(), 1'700'000'000'000'000'000); }

}  // namespace
}  // namespace sightline
