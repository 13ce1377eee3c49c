#include "sightline/record/team_json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sightline {
namespace {

constexpr const char* scene = R"(
[agent.uav0]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0] }
[agent.uav1]
robot = "multirotor"
start = { p = [1.5, 0.0, 1.0] }
sensor = { pitch = 0.25, offset = 0.125 }
[obstacle.rock]
p = [0.0, -2.0, 1.0]
[[shape]]
chain = ["uav0", "uav1"]
potentials = [ { sensor_cone = { alpha = 0.75 } }, { keep_out = { d_min = 1.25 } }, { cohesion = { d_max = 3.0 } } ]
felt_by = "observer"
[[couple]]
potential = { keep_out = { d_min = 0.5 } }
between = ["uav1", "uav0"]
[[couple]]
potential = { keep_out = { d_min = 0.5 } }
between = ["rock", "uav0"]
[[event]]
name = "look away"
at = 5.0
observe = { observer = "uav1", target = "rock" }
)";

TEST(TeamJson, AMountHasTheNumbersThatDifferFromOneAhead) {
  std::string text = scene;
  const auto pair = [&] {
    return nlohmann::json::parse(team_json(parse_scenario(text, "a.toml")))["pairs"][0].dump();
  };
  EXPECT_NE(pair().find(R"("offset":0.125,"pitch":0.25)"), std::string::npos);
  EXPECT_EQ(pair().find("yaw"), std::string::npos);
  const std::string_view plain = "{ pitch = 0.25, offset = 0.125 }";
  text.replace(text.find(plain), plain.size(),
               "{ yaw = 1.5, pitch = 0.25, roll = -0.5, offset = [0.125, 0.25, -0.5] }");
  EXPECT_NE(pair().find(R"("offset":[0.125,0.25,-0.5],"pitch":0.25,"roll":-0.5,"target":0,"yaw":1.5)"),
            std::string::npos);
}

TEST(TeamJson, BodiesPairsAndEventsAreToldInTheirOrder) {
  const auto json = nlohmann::json::parse(team_json(parse_scenario(scene, "a.toml")));
  ASSERT_EQ(json["bodies"].size(), 3U);
  EXPECT_EQ(json["bodies"][1]["name"], "uav1");
  EXPECT_EQ(json["bodies"][2]["kind"], "obstacle");
  ASSERT_EQ(json["pairs"].size(), 2U) << "the second is what an event brings";
  EXPECT_EQ(json["pairs"][0]["observer"], 1);
  EXPECT_EQ(json["pairs"][0]["target"], 0);
  EXPECT_EQ(json["pairs"][0]["alpha"], 0.75);
  EXPECT_EQ(json["pairs"][0]["d_min"], 1.25);
  EXPECT_EQ(json["pairs"][1]["target"], 2);
  EXPECT_EQ(json["events"], nlohmann::json({"look away"}));
}

TEST(TeamJson, HardDistancesAndTheFloorAreToldWhereThereAreSome) {
  const auto without = nlohmann::json::parse(team_json(parse_scenario(scene, "a.toml")));
  EXPECT_FALSE(without.contains("d_hard") || without.contains("floor"));
  const auto with = nlohmann::json::parse(
      team_json(parse_scenario(std::string(scene) + "[safety]\nd_hard = 0.5\nfloor = 0.2\n", "a.toml")));
  EXPECT_EQ(with["d_hard"], nlohmann::json({0.5}));
  EXPECT_EQ(with["floor"], 0.2);
  EXPECT_TRUE(with.contains("ceiling"));
  EXPECT_FALSE(with.contains("zones"));
  const auto zones = nlohmann::json::parse(team_json(parse_scenario(
      std::string(scene) + "[[safety.zone]]\npolygon = [[90, 90], [91, 90], [91, 92]]\nkeep = \"outside\"\n",
      "a.toml")));
  EXPECT_EQ(zones["zones"], nlohmann::json::parse("[[[90.0, 90.0], [91.0, 90.0], [91.0, 92.0]]]"));
}

TEST(TeamJson, BodiesThatAreCoupledByManyPotentialsAreToldOnceForThoseWhoFeelThem) {
  const auto json = nlohmann::json::parse(team_json(parse_scenario(scene, "a.toml")));
  const auto& couplings = json["couplings"];
  ASSERT_GE(couplings.size(), 3U);
  EXPECT_EQ(couplings[0]["between"], (nlohmann::json{1, 0}));
  std::set<std::string> reported;
  for (const auto& entry : couplings) EXPECT_TRUE(reported.insert(entry.dump()).second) << entry;
  EXPECT_TRUE(reported.contains(R"({"between":[1,0],"felt":[true,false]})"));
  EXPECT_TRUE(reported.contains(R"({"between":[1,0],"felt":[true,true]})"));
  EXPECT_TRUE(reported.contains(R"({"between":[2,0],"felt":[false,true]})"));
}

}  // namespace
}  // namespace sightline
