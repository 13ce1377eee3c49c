#include "sightline/server/flight_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <list>
#include <thread>

#include "sightline/scenario/closed_loop.hpp"
#include "sightline/server/paced_clock.hpp"
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
  Sample sample = sized_sample(*world, controls.controllers());
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
  EXPECT_THAT(PageClient(flight.port()).ask("GET /scene.json"), HasSubstr("\"live\":true"));
  PageClient client(flight.port());
  ASSERT_THAT(client.watch(), testing::StartsWith("HTTP/1.1 101"));
  std::string heard;
  std::thread watcher([&] { heard = client.hear("\"t\":0.990", 5.0); });
  const LoopOutcome outcome = flight.fly();
  watcher.join();
  EXPECT_TRUE(outcome.finite);
  EXPECT_EQ(outcome.updates, 100);
  EXPECT_THAT(heard, HasSubstr("\"t\":0.990"));
  EXPECT_THAT(heard, HasSubstr("\"paths\":[["));
  EXPECT_THAT(heard, HasSubstr("look away"));
  EXPECT_EQ(flight.page.dropped(), 0);
}

// The promise to the loop: ten who look on, of whom one reads nothing and others come and go, hold up nothing.
TEST(FlightPage, WatchersThatReadNothingOrLeaveDoNotHoldUpTheLoop) {
  ShownFlight flight(2.0);
  std::list<PageClient> watchers;
  for (int i = 0; i < 9; ++i) watchers.emplace_back(flight.port());
  PageClient deaf(flight.port(), 2048);
  for (PageClient& one : watchers) one.watch();
  deaf.watch();
  std::thread leaving([&] {
    while (!watchers.empty()) {
      (void)watchers.front().hear("\"t\"", 1.0);
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
