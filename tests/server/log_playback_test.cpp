#include "sightline/server/log_playback.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>

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

/// Hears a topic, after the client subscribed to it.
class Listener {
 public:
  Listener(std::uint16_t port, std::string_view topic) : client(port) {
    EXPECT_TRUE(client.ask_for_topics().starts_with("HTTP/1.1 101"));
    const auto channel = test::advertised(ears_.next_op(client, "advertise"), topic);
    EXPECT_TRUE(channel);
    client.say(test::subscribe_frame(0, channel.value_or(0)));
  }
  /// The time of the topic's next message; none comes: the greatest number.
  std::uint64_t next() {
    while (const auto received = ears_.next(client))
      if (received->is_message()) return received->time();
    return std::numeric_limits<std::uint64_t>::max();
  }

  PageClient client;

 private:
  test::FoxgloveEars ears_;
};

TEST(LogPlayback, PlaysAllMessagesAsFastAsTheyWereLoggedAndBeginsAnew) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  LogPlayback playback(played_log(scenario), scenario);
  const PageServer server({}, {}, &playback.feed());
  Listener listener(server.port(), "/uav1/pose");
  // 100 periods, the states after the last command, and the first again.
  std::chrono::steady_clock::time_point first, last;
  for (std::size_t k = 0; k < 102; ++k) {
    ASSERT_EQ(listener.next(), k == 101 ? 0 : 10'000'000 * k);
    if (k == 0) first = std::chrono::steady_clock::now();
    if (k == 99) last = std::chrono::steady_clock::now();
  }
  const double seconds = std::chrono::duration<double>(last - first).count();
  EXPECT_GT(seconds, 0.9);
  EXPECT_LT(seconds, 5.0);
}

TEST(LogPlayback, BeginsAtTheBeginForWhoComesWhenNobodyListened) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  LogPlayback playback(played_log(scenario), scenario);
  const PageServer server({}, {}, &playback.feed());
  for (int visit = 0; visit < 2; ++visit) {
    Listener listener(server.port(), "/uav0/state");
    for (std::uint64_t k = 0; k < 10; ++k) ASSERT_EQ(listener.next(), 10'000'000 * k);
    listener.client.say(PageClient::masked(8, ""));
    EXPECT_TRUE(test::eventually([&] { return server.counts().watchers == 0; }));
    EXPECT_TRUE(test::eventually([&] { return !playback.feed().is_requested(); }));
    ::usleep(300'000);
  }
}

TEST(LogPlayback, WhatIsNoLogIsRefusedByItsName) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  EXPECT_THROW(LogPlayback("/nowhere/run.mcap", scenario), std::runtime_error);
}

}  // namespace
}  // namespace sightline
