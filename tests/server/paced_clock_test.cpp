#include "sightline/server/paced_clock.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace sightline {
namespace {

double flown_seconds(PacedClock& clock, int periods) {
  const auto began = std::chrono::steady_clock::now();
  clock.start(0.01);
  for (int k = 0; k < periods; ++k) EXPECT_EQ(clock.wait(k), k);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
}

TEST(PacedClock, TimeGoesAsFastAsAskedAndNoPeriodIsSkipped) {
  const std::atomic<bool> stop{false};
  PacedClock plain(1.0, false, stop), fast(4.0, false, stop);
  EXPECT_GE(flown_seconds(plain, 21), 0.199);
  EXPECT_GE(flown_seconds(fast, 41), 0.099);
  EXPECT_LT(flown_seconds(fast, 41), 5.0);
}

TEST(PacedClock, APausedFlightWaitsAfterItsFirstPeriodUntilItIsLetGo) {
  const std::atomic<bool> stop{false};
  PacedClock clock(1000.0, true, stop);
  clock.start(0.01);
  EXPECT_EQ(clock.wait(0), 0);
  EXPECT_TRUE(clock.paused());
  std::thread person([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    clock.resume();
  });
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(clock.wait(1), 1);
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(90));
  person.join();
}

TEST(PacedClock, WhoStopsIsNotHeldUp) {
  const std::atomic<bool> stop{true};
  PacedClock clock(0.001, true, stop);
  EXPECT_LT(flown_seconds(clock, 10), 2.0);
}

}  // namespace
}  // namespace sightline
