#include "sightline/server/scene_json.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using nlohmann::json;

ShownState pair_state() {
  ShownState state;
  state.time = 1.25;
  const auto at = [](double x, double y, double z) { return Sight<double>{{{x, y, z}, {1, 0}}, {}, {}}; };
  state.seen = {at(0, 0, 1), at(1, 0, 0.5), at(4, 0, 1)};
  state.u = {1, 2, 3, 4, 5, 6, 7, 8};
  state.status = "converged";
  return state;
}

TEST(SceneJson, ASceneSaysBodiesLimitsAndWhoIsToSeeWhom) {
  const SceneJson scene(test::scenario_of(test::view_scenario));
  const json said = json::parse(scene.scene("word", true));
  EXPECT_EQ(said["session"], "word");
  EXPECT_EQ(said["live"], true);
  ASSERT_EQ(said["bodies"].size(), 3U);
  EXPECT_EQ(said["bodies"][0]["name"], "uav0");
  EXPECT_EQ(said["bodies"][0]["inputs"].size(), said["bodies"][0]["u_max"].size());
  EXPECT_EQ(said["bodies"][2]["agent"], false);
  EXPECT_EQ(said["bodies"][2]["hard"], 0.5);
  ASSERT_EQ(said["pairs"].size(), 1U);
  EXPECT_EQ(said["pairs"][0]["observer"], 0);
  EXPECT_EQ(said["pairs"][0]["target"], 1);
  EXPECT_EQ(said["pairs"][0]["alpha"], 0.5);
  EXPECT_EQ(said["pairs"][0]["d_min"], 1.0);
}

TEST(SceneJson, AMountHasItsPlaceAndAQuaternion) {
  std::string text = test::view_scenario;
  const std::string_view plain = "pitch = 0.5\noffset = 0.17";
  text.replace(text.find(plain), plain.size(), "yaw = 1.2\npitch = 0.0\noffset = [0.125, 0.25, -0.5]");
  const json mount = json::parse(SceneJson(test::scenario_of(text)).scene("word", true))["pairs"][0]["mount"];
  EXPECT_EQ(mount["offset"], json::parse("[0.125, 0.25, -0.5]"));
  EXPECT_EQ(mount["on_body"], false);
  ASSERT_EQ(mount["turned"].size(), 4U);
  EXPECT_NEAR(mount["turned"][0].get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(mount["turned"][1].get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(mount["turned"][2].get<double>(), std::sin(0.6), 1e-12) << "a turn to the left about z";
  EXPECT_NEAR(mount["turned"][3].get<double>(), std::cos(0.6), 1e-12);
}

TEST(SceneJson, AMomentHasPosesViewsAndInputsInTheOrderOfTheScene) {
  const SceneJson scene(test::scenario_of(test::view_scenario));
  const json said = json::parse(scene.moment(pair_state(), {{3, 1.0, "a \"word\""}}));
  EXPECT_EQ(said["t"], 1.25);
  EXPECT_EQ(said["b"][1], json::parse("[1.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]"));
  EXPECT_EQ(said["p"][0][0], 1);
  EXPECT_NEAR(said["p"][0][1].get<double>(), std::sqrt(1.25), 1e-3);
  EXPECT_LT(said["p"][0][2].get<double>(), 0.5);
  EXPECT_EQ(said["u"], json::parse("[[1, 2, 3, 4], [5, 6, 7, 8]]"));
  EXPECT_EQ(said["events"], json::parse(R"([[3, 1.0, "a \"word\""]])"));
  EXPECT_FALSE(said.contains("paths"));
}

TEST(SceneJson, ASceneHasTheSurfacesOfItsLimitsEachOnce) {
  std::string text = test::view_scenario;
  text += R"toml(
[agent.uav1.sensor]
pitch = 0.0
offset = 0.1
[[couple]]
potential = { sensor = { inside = { all_of = ["abs(azimuth) < 0.4", "range < 3 m"] } } }
between = ["uav1", "uav0"]
felt_by = ["uav1"]
weight = 0.1
[[couple]]
potential = { region = { inside = { any_of = ["abs(r_x) > 1 m", "abs(r_y) > 0.5 m", "abs(r_z) > 1 m"] } } }
between = ["uav0", "post"]
weight = 0.1
[[couple]]
potential = { region = { inside = { any_of = ["abs(r_x) > 1 m", "abs(r_y) > 0.5 m", "abs(r_z) > 1 m"] } } }
between = ["uav1", "post"]
weight = 0.1
[[couple]]
potential = { region = { inside = { all_of = ["hypot(observer.p_x + 1 m, r_y) > 0.5 m"] } } }
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 0.1
)toml";
  const json said = json::parse(SceneJson(test::scenario_of(text)).scene("word", true));
  ASSERT_EQ(said["pairs"].size(), 2U);
  EXPECT_EQ(said["surfaces"].size(), 3U);
  EXPECT_EQ(said["surfaces"][said["pairs"][0]["surface"].get<std::size_t>()]["scales"], true);
  EXPECT_EQ(said["surfaces"][said["pairs"][1]["surface"].get<std::size_t>()]["scales"], false);
  ASSERT_EQ(said["zones"].size(), 1U);
  EXPECT_EQ(said["zones"][0]["body"], 2);
  ASSERT_EQ(said["undrawn"].size(), 1U);
  EXPECT_NE(said["undrawn"][0].get<std::string>().find("of uav0 › uav1: not drawn: its limit depends"),
            std::string::npos);
}

TEST(SceneJson, ASceneHasThePrismsOfItsZones) {
  const std::string zones = R"toml(
[[safety.zone]]
polygon = [[50, 50], [51, 50], [51, 52.5]]
from = 1.0
keep = "outside"
)toml";
  const json said =
      json::parse(SceneJson(test::scenario_of(test::view_scenario + zones)).scene("word", true));
  EXPECT_EQ(said["prisms"], json::parse(R"([{"polygon": [50.0, 50.0, 51.0, 50.0, 51.0, 52.5],
                                             "low": 1.0, "high": 4.0, "keep": "outside"}])"));
  EXPECT_EQ(json::parse(SceneJson(test::scenario_of(test::view_scenario)).scene("word", true))["prisms"],
            json::array());
}

TEST(SceneJson, AnEstimateHasItsCovarianceItsErrorAndItsDeviation) {
  const SceneJson scene(test::scenario_of(test::view_scenario));
  ShownState state = pair_state();
  state.estimates.resize(2);
  PoseEstimate& estimate = state.estimates[1];
  estimate.known = true;
  estimate.p = {1.0, 0.3, 0.9};
  estimate.P(0, 0) = 0.01, estimate.P(1, 1) = 0.04, estimate.P(2, 2) = 0.04,
                estimate.P(0, 1) = estimate.P(1, 0) = 0.002;
  const json said = json::parse(scene.moment(state, {}));
  EXPECT_TRUE(said["e"][0].is_null());
  EXPECT_EQ(said["e"][1], json::parse("[1.0, 0.3, 0.9, 0.01, 0.002, 0, 0.04, 0, 0.04, 0.5, 0.3]"));
  state.truth_known = false;
  EXPECT_TRUE(json::parse(scene.moment(state, {}))["e"][1][9].is_null());
  state.estimates.clear();
  EXPECT_FALSE(json::parse(scene.moment(state, {})).contains("e"));
}

TEST(SceneJson, WhatIsNotThereOrNotFiniteIsNull) {
  const SceneJson scene(test::scenario_of(test::view_scenario));
  ShownState state = pair_state();
  state.seen[1]->p.x = std::numeric_limits<double>::quiet_NaN();
  state.seen[2].reset();
  state.residual = std::numeric_limits<double>::infinity();
  state.u[0] = state.residual;
  const json said = json::parse(scene.moment(state, {}));
  EXPECT_TRUE(said["b"][1].is_null() && said["b"][2].is_null());
  EXPECT_TRUE(said["p"][0].is_null());
  EXPECT_TRUE(said["residual"].is_null() && said["u"][0][0].is_null());
}

TEST(SceneJson, APairThatAnEventTookAwayIsNotJudged) {
  const Scenario scenario = test::scenario_of(test::view_scenario);
  const SceneJson scene(scenario);
  PresentTeam present(scenario);
  EXPECT_EQ(scene.requested(present), std::vector<char>{1});
  Sample sample;
  sample.time = 0.5;
  sample.event_count = 1;
  sample.events[0] = {0.5, EventKind::event_in_force, 0, 0.0};
  present.follow(sample);
  EXPECT_EQ(scene.requested(present), std::vector<char>{0});
  ShownState state = pair_state();
  state.requested = scene.requested(present);
  EXPECT_TRUE(json::parse(scene.moment(state, {}))["p"][0].is_null());
}

TEST(SceneJson, EventsAreInWords) {
  const SceneJson scene(test::scenario_of(test::view_scenario));
  EXPECT_EQ(scene.describe("event_in_force", 0), "event \"look away\" in force");
  EXPECT_EQ(scene.describe("event_in_force", 9), "event \"?\" in force");
  EXPECT_EQ(scene.describe("hold", 1), "uav1: hold");
  EXPECT_EQ(scene.describe("hold", 17), "?: hold");
  EXPECT_EQ(scene.describe("solver_status", 0), "solver: converged");
  EXPECT_EQ(scene.describe("missed_period", 3), "3 periods missed");
}

}  // namespace
}  // namespace sightline
