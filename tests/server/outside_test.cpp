// What goes wrong beside the control path, while something is flown, watched and logged: no flight
// ends by it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <optional>
#include <thread>

#include "sightline/base.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "sightline/server/flight_page.hpp"
#include "tests/support/counted_new.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/page_client.hpp"
#include "tests/support/passing_sink.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using test::eventually;
using test::PageClient;

/// A flight with a log, a page and somebody who observes it.
struct WatchedFlight {
  explicit WatchedFlight(double duration) : scenario(test::scenario_of(test::view_scenario)) {
    scenario.simulation.duration = duration;
  }

  /// @param go_wrong  flies the loop amid what goes wrong
  LoggedFlight fly(const std::function<LoopOutcome(ClosedLoop&)>& go_wrong, FlightOptions options = {}) {
    options.team_switcher = controls.team_switcher();
    options.watched = [&](Sink<Sample>& log, const Sample& prototype) -> Sink<Sample>& {
      page.emplace(scenario, prototype);
      const std::string& url = page->url();
      port = static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
      watcher.emplace(port);
      EXPECT_THAT(watcher->watch(), testing::StartsWith("HTTP/1.1 101"));
      return sink.emplace(log, [this](Sample& sample) { page->show(sample); });
    };
    options.fly = [&](ClosedLoop& loop, Sink<Sample>&) { return go_wrong(loop); };
    return fly_logged(scenario, folder, clock, controls.controllers(), options);
  }

  Scenario scenario;
  Controls controls{scenario};
  SimulatedClock clock;
  std::filesystem::path folder = test::fresh_folder();
  std::optional<FlightPage> page;
  std::uint16_t port = 0;
  std::optional<PageClient> watcher;
  std::optional<test::PassingSink> sink;
};

TEST(Outside, NoMemoryForPageAndLogEndsNoFlight) {
  static std::atomic<int> reports;
  reports = 0;
  report_failures_to([](std::string_view) noexcept { ++reports; });
  WatchedFlight flight(20.0);
  std::int64_t failed = 0;
  const LoggedFlight flown = flight.fly([&](ClosedLoop& loop) {
    const NoMemoryElsewhere none;
    const LoopOutcome outcome = loop.fly();
    EXPECT_TRUE(eventually([&] { return reports > 0; }));
    failed = none.failed();
    return outcome;
  });
  report_failures_to(nullptr);
  EXPECT_EQ(flown.outcome.updates, 2000);
  EXPECT_TRUE(flown.outcome.finite);
  EXPECT_GT(failed, 0);
  EXPECT_FALSE(flown.logged);  // and it is said
  EXPECT_THAT(flown.faults, testing::Contains(testing::HasSubstr("memory")));
}

TEST(Outside, ALogThatCannotBeClosedForWantOfMemoryHasItsMessagesAndNoEnd) {
  const std::filesystem::path file = test::fresh_folder() / "run.mcap";
  auto writer = std::make_unique<McapWriter>(file, "", "");
  const ChannelId channel = writer->channel(writer->schema("text", "", ""), "/text", "json", {});
  const std::string text = "{}";
  writer->message(channel, 0, 1, std::as_bytes(std::span(text)));
  writer->flush();
  writer->message(channel, 1, 2, std::as_bytes(std::span(text)));
  {
    const NoMemoryElsewhere none;
    run_apart([&] { writer.reset(); });
  }
  McapReader reader(file);
  int messages = 0;
  EXPECT_TRUE(reader.visit([&](const McapMessage&) { ++messages; })) << reader.error();
  EXPECT_EQ(messages, 2);
  EXPECT_TRUE(reader.truncated());
}

TEST(Outside, NoDescriptorLeftEndsNoFlight) {
  // UBSan needs a pipe when it meets a type for the first time: a flight before shows it the types.
  WatchedFlight(5.0).fly([](ClosedLoop& loop) { return loop.fly(); });
  WatchedFlight flight(5.0);
  const LoggedFlight flown = flight.fly([&](ClosedLoop& loop) {
    std::vector<int> taken;
    for (int fd = 0; (fd = ::dup(STDIN_FILENO)) >= 0;) taken.push_back(fd);
    const LoopOutcome outcome = loop.fly();
    for (const int fd : taken) ::close(fd);
    return outcome;
  });
  EXPECT_EQ(flown.outcome.updates, 500);
  EXPECT_TRUE(flown.logged);
  EXPECT_THAT(PageClient(flight.port).request("GET /scene.json"), testing::StartsWith("HTTP/1.1 200"));
}

TEST(Outside, AStuckLogHoldsNoStopUp) {
  WatchedFlight flight(60.0);
  std::atomic<bool> stop = false, ended = false, go_on = false;
  std::thread person([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    stop = true;
    EXPECT_TRUE(eventually([&] { return ended.load(); }));
    go_on = true;
  });
  const LoggedFlight flown = flight.fly(
      [&](ClosedLoop& loop) {
        const LoopOutcome outcome = loop.fly();
        ended = true;
        return outcome;
      },
      {.stop = &stop, .written = [&](double) { EXPECT_TRUE(eventually([&] { return go_on.load(); })); }});
  person.join();
  EXPECT_TRUE(flown.outcome.stopped);
  EXPECT_LT(flown.outcome.updates, 6000);
}

}  // namespace
}  // namespace sightline
