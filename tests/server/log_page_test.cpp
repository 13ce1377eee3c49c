#include "sightline/server/log_page.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sightline/record/log.hpp"
#include "sightline/record/planned_view.hpp"
#include "sightline/scenario/closed_loop.hpp"
#include "tests/support/folder.hpp"
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
  Sample prototype = sized_sample(*world, controls.controllers());
  make_room_for_plans(scenario, prototype);
  Ring<Sample> ring(64, prototype);
  SimulatedClock clock;
  ClosedLoop loop(scenario, *world, controls.controllers(), clock, ring, nullptr, controls.team_switcher());
  Log log(scenario, folder, controls.controllers(), ring);
  log.start();
  (void)loop.fly();
  log.finish();
  EXPECT_EQ(log.error(), "");
  return folder;
}

TEST(LogPage, MomentsOfALogHaveWhatALiveFlightShows) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const PageFiles files = log_page(logged_flight(scenario), scenario);
  EXPECT_EQ(json::parse(files.at("/scene.json").body)["live"], false);
  EXPECT_FALSE(files.at("/moments.json").open);
  const json moments = json::parse(files.at("/moments.json").body);
  ASSERT_EQ(moments.size(), 100U);
  EXPECT_EQ(moments.front()["b"][0][0], -0.6);
  EXPECT_EQ(moments.back()["t"], 0.99);
  EXPECT_EQ(moments.front()["paths"].size(), 2U);
  EXPECT_GT(moments.front()["paths"][0].size(), 3U);
  // Before the event and after it.
  EXPECT_TRUE(moments[10]["p"][0].is_array());
  EXPECT_TRUE(moments[99]["p"][0].is_null());
  int events = 0;
  for (const json& moment : moments) events += static_cast<int>(moment.value("events", json::array()).size());
  EXPECT_GE(events, 1);
}

TEST(LogPage, ALargeLogIsThinnedEvenlyWithAllItsEvents) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const fs::path folder = logged_flight(scenario);
  const json moments = json::parse(log_moments(folder, scenario, 10 * 3 * 7));
  EXPECT_EQ(moments.size(), 10U);
  EXPECT_EQ(moments[1]["t"], 0.1);
  EXPECT_TRUE(
      std::any_of(moments.begin(), moments.end(), [](const json& m) { return m.contains("events"); }));
}

TEST(LogPage, ALogOfAnotherTeamIsRefused) {
  const fs::path folder = logged_flight(test::scenario_of(test::view_scenario));
  std::string other = test::view_scenario;
  other.replace(other.find("[obstacle.post]"), 15, "[obstacle.pole]");
  EXPECT_THROW((void)log_moments(folder, test::scenario_of(other)), std::runtime_error);
  EXPECT_THROW((void)log_moments(folder / "none", test::scenario_of(other)), std::runtime_error);
}

}  // namespace
}  // namespace sightline
