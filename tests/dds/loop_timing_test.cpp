#include "bridges/dds/fleet/loop_timing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

const std::string two =
    "[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.b]\nrobot = \"multirotor\"\nstart "
    "= { p = [3, 0, 1] }\n";

TEST(LoopTiming, TheLoopRunsForThatLongAtItsPeriod) {
  const auto begin = std::chrono::steady_clock::now();
  const LoopTiming timing = time_loop(test::scenario_of(two), 0.5);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(took.count(), 0.48);
  EXPECT_NEAR(static_cast<double>(timing.periods), 50, 2);
  EXPECT_EQ(timing.period, 0.01);
  EXPECT_GT(timing.update_median, 0.0);
  EXPECT_LE(timing.update_median, timing.update_p99);
  EXPECT_LE(timing.update_p99, timing.update_most);
  EXPECT_GE(timing.wake_p99, 0.0);
  EXPECT_THAT(timing.finding().sentence, HasSubstr(" periods of 10 ms: updates take "));
  EXPECT_THAT(timing.finding().sentence, HasSubstr(timing.realtime.sentence()));
}

// A horizon of 1000 stages for 64 robots in 0.1 ms: 640 000 stages a millisecond, which no machine
// keeps.
TEST(LoopTiming, AMachineThatCannotKeepUpIsRed) {
  const LoopTiming timing =
      time_loop(test::scenario_of("[horizon]\nperiod = 0.0001\nstages = 1000\n[agent.\"r{0..63}\"]\nrobot = "
                                  "\"multirotor\"\nstart = { p = { place = \"line\", from = [0, 0, 1], to = "
                                  "[200, 0, 1] } }\n"),
                0.3);
  EXPECT_GT(timing.missed, timing.periods / 10);
  EXPECT_EQ(timing.finding().light, Light::red);
  EXPECT_THAT(timing.finding().sentence, HasSubstr("missed, expected at most 2 %"));
}

TEST(LoopTiming, WhatKeepsItsPeriodsIsGreen) {
  LoopTiming timing{.period = 0.01, .periods = 1000, .missed = 20, .update_p99 = 0.002};
  EXPECT_EQ(timing.finding().light, Light::green);
  timing.missed = 21;
  EXPECT_EQ(timing.finding().light, Light::red);
  timing.missed = 0;
  timing.update_p99 = 0.011;
  EXPECT_EQ(timing.finding().light, Light::red);
}

}  // namespace
}  // namespace sightline
