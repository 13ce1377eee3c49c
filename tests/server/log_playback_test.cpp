#include "sightline/server/log_playback.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "sightline/log.hpp"
#include "sightline/server/page_server.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/foxglove_ears.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using test::PageClient;

std::filesystem::path played_log(const Scenario& scenario) {
  const auto folder = test::fresh_folder();
  const Controls controls(scenario);
  SimulatedClock clock;
  EXPECT_TRUE(
      fly_logged(scenario, folder, clock, controls.controllers(), {.team_switcher = controls.team_switcher()})
          .logged);
  return folder / "run.mcap";
}

TEST(LogPlayback, PlaysAllMessagesAsFastAsTheyWereLoggedAndBeginsAnew) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  LogPlayback playback(played_log(scenario), scenario);
  const PageServer server({}, {}, &playback.feed());
  PageClient client(server.port());
  ASSERT_TRUE(client.ask_for_topics().starts_with("HTTP/1.1 101"));
  test::FoxgloveEars ears;
  const auto channel = test::advertised(ears.next_op(client, "advertise"), "/uav1/pose");
  ASSERT_TRUE(channel);
  client.say(test::subscribe_frame(0, *channel));
  std::vector<std::uint64_t> times;
  std::chrono::steady_clock::time_point first, last;
  while (times.size() < 102) {
    const auto received = ears.next(client);
    ASSERT_TRUE(received);
    if (!received->is_message()) continue;
    times.push_back(received->time());
    if (times.size() == 1) first = std::chrono::steady_clock::now();
    if (times.size() == 100) last = std::chrono::steady_clock::now();
  }
  // 100 periods, and the states after the last command.
  for (std::size_t k = 0; k <= 100; ++k) EXPECT_EQ(times[k], 10'000'000 * k);
  EXPECT_EQ(times[101], 0U);
  const double seconds = std::chrono::duration<double>(last - first).count();
  EXPECT_GT(seconds, 0.9);
  EXPECT_LT(seconds, 5.0);
}

TEST(LogPlayback, BeginsAtTheBeginForWhoComesWhenNobodyListened) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  LogPlayback playback(played_log(scenario), scenario);
  const PageServer server({}, {}, &playback.feed());
  for (int visit = 0; visit < 2; ++visit) {
    PageClient client(server.port());
    ASSERT_TRUE(client.ask_for_topics().starts_with("HTTP/1.1 101"));
    test::FoxgloveEars ears;
    const auto channel = test::advertised(ears.next_op(client, "advertise"), "/uav0/state");
    ASSERT_TRUE(channel);
    client.say(test::subscribe_frame(0, *channel));
    std::uint64_t time = 1;
    for (int count = 0; count < 10;) {
      const auto received = ears.next(client);
      ASSERT_TRUE(received);
      if (!received->is_message()) continue;
      if (count == 0) {
        EXPECT_EQ(received->time(), 0U);
      }
      ++count;
      time = received->time();
    }
    EXPECT_EQ(time, 90'000'000U);
    client.say(PageClient::masked(8, ""));
    EXPECT_TRUE(test::soon([&] { return server.counts().watchers == 0; }));
    EXPECT_TRUE(test::soon([&] { return !playback.feed().is_requested(); }));
    ::usleep(300'000);
  }
}

TEST(LogPlayback, WhatIsNoLogIsRefusedByItsName) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  EXPECT_THROW(LogPlayback("/nowhere/run.mcap", scenario), std::runtime_error);
}

}  // namespace
}  // namespace sightline
