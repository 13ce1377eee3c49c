#include "sightline/server/log_page.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "sightline/judge/planned_view.hpp"
#include "sightline/log.hpp"
#include "sightline/record/log.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/page_client.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

fs::path logged_flight(const Scenario& scenario) {
  const fs::path folder = test::fresh_folder();
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  Sample prototype = sized_sample(*world, controls.controllers(), controls.team_switcher());
  make_room_for_plans(scenario, prototype);
  SpscQueue<Sample> ring(64, prototype);
  SimulatedClock clock;
  ClosedLoop loop(scenario, *world, controls.controllers(), clock, ring, nullptr, controls.team_switcher());
  Log log(scenario, folder, controls.controllers(), ring);
  log.start();
  (void)loop.fly();
  log.finish();
  EXPECT_EQ(log.error(), "");
  return folder;
}

/// The moments of a log that has ended.
json moments_of(const fs::path& folder, const Scenario& scenario, std::size_t numbers = 1'000'000) {
  json list = json::array();
  for (const std::string& moment : LogMoments(folder, scenario, numbers).read_on())
    list.push_back(json::parse(moment));
  return list;
}

void save_bytes(const fs::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// A log that grows as its writer lets it.
class GrowingLog {
 public:
  explicit GrowingLog(const fs::path& of)
      : folder(of.parent_path() / (of.filename().string() + "_growing")),
        log_(test::read_file(of / "run.mcap")),
        times_(test::read_file(of / "timing.csv")) {
    fs::remove_all(folder);
    writer_.emplace(folder, std::initializer_list<std::string_view>{});
    grow(0.2);
  }
  void grow(double share) {
    save_bytes(folder / "timing.csv", std::string_view(times_).substr(0, part(times_, share)));
    save_bytes(folder / "run.mcap", std::string_view(log_).substr(0, part(log_, share)));
  }
  /// The writer ends, as it does when it is killed.
  void leave() { writer_.reset(); }

  fs::path folder;

 private:
  static std::size_t part(const std::string& all, double share) {
    return static_cast<std::size_t>(share * static_cast<double>(all.size()));
  }
  std::string log_, times_;
  std::optional<FolderLock> writer_;
};

TEST(LogPage, MomentsOfALogHaveWhatALiveFlightShows) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const json moments = moments_of(logged_flight(scenario), scenario);
  ASSERT_EQ(moments.size(), 100U);
  EXPECT_EQ(moments.front()["b"][0][0], -0.6);
  EXPECT_EQ(moments.back()["t"], 0.99);
  EXPECT_EQ(moments.front()["paths"].size(), 2U);
  EXPECT_GT(moments.front()["paths"][0].size(), 3U);
  EXPECT_EQ(moments.front()["levels"], json::parse(R"(["valid", "valid", "valid"])"));
  // Before the event and after it.
  EXPECT_TRUE(moments[10]["p"][0].is_array());
  EXPECT_TRUE(moments[99]["p"][0].is_null());
  int events = 0;
  for (const json& moment : moments) events += static_cast<int>(moment.value("events", json::array()).size());
  EXPECT_GE(events, 1);
}

TEST(LogPage, ALargeLogIsThinnedEvenlyWithAllItsEvents) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const json moments = moments_of(logged_flight(scenario), scenario, 10 * 3 * 7);
  EXPECT_EQ(moments.size(), 10U);
  EXPECT_EQ(moments[1]["t"], 0.1);
  EXPECT_TRUE(
      std::any_of(moments.begin(), moments.end(), [](const json& m) { return m.contains("events"); }));
}

TEST(LogPage, ALogOfAnotherTeamIsRefused) {
  const fs::path folder = logged_flight(test::scenario_of(test::view_scenario));
  std::string other = test::view_scenario;
  other.replace(other.find("[obstacle.post]"), 15, "[obstacle.pole]");
  EXPECT_THROW(LogMoments(folder, test::scenario_of(other)), std::runtime_error);
  EXPECT_THROW(LogMoments(folder / "none", test::scenario_of(other)), std::runtime_error);
}

TEST(LogPage, TheMomentsOfALogThatGrowsAreThoseOfTheFinishedOne) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const fs::path finished = logged_flight(scenario);
  const std::vector<std::string> all = LogMoments(finished, scenario).read_on();
  GrowingLog log(finished);
  LogMoments moments(log.folder, scenario);
  std::vector<std::string> seen;
  for (int share = 20; share <= 100; share += 5) {
    log.grow(0.01 * share);
    const std::vector<std::string> more = moments.read_on();
    seen.insert(seen.end(), more.begin(), more.end());
    EXPECT_EQ(moments.state(), share < 100 ? LogState::growing : LogState::finished);
    EXPECT_TRUE(std::equal(seen.begin(), seen.end(), all.begin()));
  }
  EXPECT_EQ(seen, all);
  EXPECT_FALSE(moments.replaced());
}

TEST(LogPage, AKilledRunIsShownAsFarAsItGoes) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  GrowingLog log(logged_flight(scenario));
  log.grow(0.6);
  LogMoments moments(log.folder, scenario);
  const std::size_t seen = moments.read_on().size();
  EXPECT_GT(seen, 20U);
  EXPECT_EQ(moments.state(), LogState::growing);
  log.leave();
  // The two files are cut at the same share of their bytes, so the log may have periods whose times
  // timing.csv has not.
  EXPECT_EQ(seen + moments.read_on().size(), LogMoments(log.folder, scenario).read_on().size());
  EXPECT_EQ(moments.state(), LogState::broken);
}

TEST(LogPage, ThePageTellsOfALogThatGrowsAndOfOneThatTakesItsPlace) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const fs::path finished = logged_flight(scenario);
  GrowingLog log(finished);
  log.grow(0.5);
  const LogPage page(log.folder, [&] { return scenario; });
  const auto body_of = [&](const std::string& path) {
    const std::string answer = test::PageClient(page.port()).request("GET " + path);
    return json::parse(answer.substr(answer.find("\r\n\r\n")));
  };
  const json scene = body_of("/scene.json");
  EXPECT_EQ(scene["live"], false);
  test::PageClient watcher(page.port());
  EXPECT_THAT(watcher.watch(), testing::StartsWith("HTTP/1.1 101"));
  EXPECT_THAT(watcher.receive("growing"), testing::HasSubstr(scene["session"].get<std::string>()));
  const std::size_t before = body_of("/moments.json").size();
  EXPECT_EQ(body_of(fmt::format("/moments.json?from={}", before - 3)).size(), 3U);
  EXPECT_EQ(body_of("/moments.json?from=2&most=5").size(), 5U);
  EXPECT_EQ(body_of("/moments.json?from=100000").size(), 0U);
  log.grow(1.0);
  EXPECT_THAT(watcher.receive("finished"), testing::HasSubstr("\"moments\":100"));
  EXPECT_EQ(body_of(fmt::format("/moments.json?from={}", before)).size(), 100 - before);
  // A run begins anew: its file takes the place of the other.
  fs::copy_file(finished / "run.mcap", log.folder / "run.mcap.part");
  fs::rename(log.folder / "run.mcap.part", log.folder / "run.mcap");
  EXPECT_TRUE(test::eventually([&] { return body_of("/scene.json")["session"] != scene["session"]; }));
  EXPECT_TRUE(test::eventually([&] { return body_of("/moments.json").size() == 100U; }));
}

}  // namespace
}  // namespace sightline
