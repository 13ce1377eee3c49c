#include "sightline/server/flight_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <list>
#include <thread>

#include "sightline/readers/cdr.hpp"
#include "sightline/scenario.hpp"
#include "sightline/server/paced_clock.hpp"
#include "tests/support/foxglove_ears.hpp"
#include "tests/support/page_client.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using test::PageClient;
using testing::HasSubstr;

/// A flight whose samples a page is shown.
struct ShownFlight {
  explicit ShownFlight(double duration) : scenario(test::scenario_of(test::view_scenario)) {
    scenario.simulation.duration = duration;
  }
  Scenario scenario;
  std::atomic<bool> stop{false};
  PacedClock clock{1.0, false, stop};
  Controls controls{scenario};
  std::unique_ptr<World> world = make_world(scenario);
  Sample sample = sized_sample(*world, controls.controllers(), controls.team_switcher());
  FlightPage page{scenario, sample};

  std::uint16_t port() const {
    const std::string& url = page.url();
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }
  LoopOutcome fly() {
    struct Shown final : Sink<Sample> {
      Shown(Sample& of, FlightPage& to) : item(of), shown(to) {}
      Sample* claim() noexcept override { return &item; }
      void publish() noexcept override { shown.show(item); }
      void close() noexcept override {}
      Sample& item;
      FlightPage& shown;
    } sink(sample, page);
    return ClosedLoop(scenario, *world, controls.controllers(), clock, sink, nullptr,
                      controls.team_switcher(), &stop)
        .fly();
  }
};

TEST(FlightPage, AWatcherSeesTheFlightWithItsPredictionsAndEvents) {
  ShownFlight flight(1.0);
  EXPECT_THAT(PageClient(flight.port()).request("GET /scene.json"), HasSubstr("\"live\":true"));
  PageClient client(flight.port());
  ASSERT_THAT(client.watch(), testing::StartsWith("HTTP/1.1 101"));
  std::string received;
  std::thread watcher([&] { received = client.receive("\"t\":0.990", 5.0); });
  const LoopOutcome outcome = flight.fly();
  watcher.join();
  EXPECT_TRUE(outcome.finite);
  EXPECT_EQ(outcome.updates, 100);
  EXPECT_THAT(received, HasSubstr("\"t\":0.990"));
  EXPECT_THAT(received, HasSubstr("\"paths\":[["));
  EXPECT_THAT(received, HasSubstr("look away"));
  EXPECT_EQ(flight.page.dropped(), 0);
}

// A log's page shows the same of the same flight: of all solvers, without the rest of the update.
TEST(FlightPage, TheSolveTimeIsThatOfTheSolvers) {
  ShownFlight flight(1.0);
  PageClient client(flight.port());
  ASSERT_THAT(client.watch(), testing::StartsWith("HTTP/1.1 101"));
  flight.sample.x = flight.scenario.x0;
  flight.sample.update_us = 500.0;
  flight.sample.solvers.assign(2, {.solve_us = 20.0});
  flight.page.show(flight.sample);
  EXPECT_THAT(client.receive("\"it\":", 5.0), HasSubstr("\"us\":40,"));
}

/// Hears the poses of uav0 until a flight of so many periods is over. @return their times, in
/// periods
std::vector<std::int64_t> hear_poses(PageClient& client, std::int64_t last) {
  test::FoxgloveEars ears;
  const auto channel = test::advertised(ears.next_op(client, "advertise"), "/uav0/pose");
  if (!channel) return {};
  client.say(test::subscribe_frame(5, *channel));
  std::vector<std::int64_t> times;
  while (times.empty() || times.back() < last) {
    const auto received = ears.next(client);
    if (!received) break;
    if (!received->is_message()) continue;
    EXPECT_EQ(received->subscription(), 5U);
    const std::string bytes = received->bytes();
    const auto pose = decode_pose(std::as_bytes(std::span(bytes)));
    EXPECT_TRUE(pose && pose->time == received->time());
    times.push_back(std::llround(1e-7 * static_cast<double>(received->time())));
  }
  return times;
}

/// But for samples that a busy machine did not show, which are counted.
void expect_each_period(const std::vector<std::int64_t>& times, std::int64_t last, std::int64_t dropped) {
  ASSERT_FALSE(times.empty());
  EXPECT_LT(times.front(), 3 * last / 4);
  EXPECT_EQ(times.back(), last);
  EXPECT_GE(static_cast<std::int64_t>(times.size()) + dropped, times.back() - times.front() + 1);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST(FlightPage, WhoSpeaksFoxglovesProtocolHearsThePoseOfEachPeriod) {
  ShownFlight flight(1.0);
  PageClient client(flight.port());
  EXPECT_THAT(client.ask_for_topics(), HasSubstr("Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n"));
  std::vector<std::int64_t> times;
  std::thread watcher([&] { times = hear_poses(client, 99); });
  EXPECT_EQ(flight.fly().updates, 100);
  watcher.join();
  expect_each_period(times, 99, flight.page.dropped());
  EXPECT_EQ(flight.page.counts().messages_dropped, 0);
}

/// All that may be tried at a port while something is flown there; each is refused or closed.
class Attackers {
 public:
  explicit Attackers(std::uint16_t port) : port_(port) {}

  void attack() {
    PageClient foreign(port_), rebound(port_);
    EXPECT_THAT(foreign.ask_for_topics("Origin: http://attacker.example\r\n"),
                testing::StartsWith("HTTP/1.1 403"));
    rebound.say(
        fmt::format("GET / HTTP/1.1\r\nHost: attacker.example:{}\r\n"
                    "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n",
                    port_));
    EXPECT_THAT(rebound.receive(), testing::StartsWith("HTTP/1.1 403"));
    half_open_.emplace_back(port_).say("GET / HTTP/1.1\r\n");
    send(test::PageClient::masked(1, std::string(1'000'000, '[')), true);
    send(test::PageClient::masked(2, std::string(1'000'000, '\xff')), true);
    std::string many;
    for (int i = 0; i < 10'000; ++i) many += test::PageClient::masked(1, R"({"op":"subscribe"})");
    send(many, true);
    send(test::PageClient::masked(1, R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":9999}]})"),
         false);
    send(test::PageClient::masked(1, std::string(60'000, '[')), false);
    send(test::PageClient::masked(2, std::string("\x01\xff\xff\xff\xff", 5)), false);
    send(std::string(100, '\xff'), true);
    for (std::size_t i = 0; i < 30; ++i) half_open_.emplace_back(port_);
  }

 private:
  /// @param closes  else it is answered by a status
  void send(const std::string& bytes, bool closes) {
    PageClient client(port_);
    if (!client.ask_for_topics().starts_with("HTTP/1.1 101")) return;  // no room, bounded too
    client.say(bytes);
    test::FoxgloveEars ears;
    const auto status = ears.next_op(client, "status", 2.0);
    while (closes && !client.ended() && !client.hear_some(2.0).empty()) continue;
    EXPECT_TRUE(closes ? client.ended() : status.is_object()) << bytes.substr(0, 40);
  }

  std::uint16_t port_;
  std::list<PageClient> half_open_;
};

// The loop does not notice, and who came before hears each pose.
TEST(FlightPage, WhatIsTriedAtItsPortTouchesNeitherTheLoopNorWhoListens) {
  ShownFlight flight(3.0);
  PageClient client(flight.port());
  ASSERT_THAT(client.ask_for_topics(), testing::StartsWith("HTTP/1.1 101"));
  std::vector<std::int64_t> times;
  std::thread watcher([&] { times = hear_poses(client, 299); });
  std::atomic<bool> done{false};
  std::thread attacking([&] {
    while (!done) Attackers(flight.port()).attack();
  });
  const LoopOutcome outcome = flight.fly();
  done = true;
  attacking.join();
  watcher.join();
  EXPECT_EQ(outcome.updates, 300);
  EXPECT_EQ(outcome.dropped, 0);
  expect_each_period(times, 299, flight.page.dropped());
  EXPECT_GT(flight.page.counts().refused, 0);
  EXPECT_GT(flight.page.counts().closed, 0);
}

// The promise to the loop: ten who look on, of whom one reads nothing and others come and go, hold
// up nothing.
TEST(FlightPage, WatchersThatReadNothingOrLeaveDoNotHoldUpTheLoop) {
  ShownFlight flight(2.0);
  std::list<PageClient> watchers;
  for (int i = 0; i < 9; ++i) watchers.emplace_back(flight.port());
  PageClient deaf(flight.port(), 2048);
  for (PageClient& one : watchers) one.watch();
  deaf.watch();
  std::thread leaving([&] {
    while (!watchers.empty()) {
      (void)watchers.front().receive("\"t\"", 1.0);
      watchers.pop_front();
    }
  });
  const auto began = std::chrono::steady_clock::now();
  const LoopOutcome outcome = flight.fly();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  leaving.join();
  EXPECT_EQ(outcome.updates, 200);
  EXPECT_EQ(outcome.dropped, 0);
  EXPECT_LT(seconds, 20.0);
}

}  // namespace
}  // namespace sightline
