#include "sightline/scenario/keys_without_effect.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "sightline/scenario.hpp"

namespace sightline {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Its speed is a state that the wind does not push, its height changes never, and no one input
// turns it.
constexpr const char* boat = R"toml(
[agent.boat]
start = { p = [0.0, 0.0, 0.0] }
[agent.boat.robot.text]
states = ["x", "y", "z", "psi", "v"]
inputs = ["left", "right"]
position = ["x", "y", "z"]
heading = "psi"
f.x = "v*cos(psi)"
f.y = "v*sin(psi)"
f.z = "0"
f.psi = "left - right"
f.v = "left + right"
)toml";
constexpr const char* point = "[agent.mass]\nrobot = \"point_mass\"\nstart = { p = [5.0, 0.0, 1.0] }\n";
constexpr const char* multirotor = "[agent.uav]\nrobot = \"multirotor\"\nstart = { p = [9.0, 0.0, 1.0] }\n";
constexpr const char* rover = "[agent.rover]\nrobot = \"omni_rover\"\nstart = { p = [9.0, 0.0, 0.0] }\n";

std::vector<std::string> unused(const std::string& text) {
  return keys_without_effect(parse_scenario(text, "a.toml"));
}

TEST(KeysWithoutEffect, AWindThatNothingTakesUpIsNamed) {
  const std::string winds =
      "[simulation.disturbance]\nwind = [3.0, 0.0, 0.0]\ngust = { sigma = 1.0, time = 1.0 }\n";
  EXPECT_THAT(unused(boat + winds), ElementsAre(HasSubstr("simulation.disturbance.wind has no effect"),
                                                HasSubstr("simulation.disturbance.gust has no effect")));
  EXPECT_THAT(unused(std::string(boat) + multirotor + winds), IsEmpty());
  EXPECT_THAT(
      unused(
          boat +
          std::string("[[event]]\nname = \"storm\"\nat = 1.0\nwind = { acceleration = [1.0, 0.0, 0.0] }\n")),
      ElementsAre(HasSubstr("wind of the event \"storm\" has no effect")));
  EXPECT_THAT(check_scenario(parse_scenario(boat + winds, "a.toml")).warnings,
              Contains(HasSubstr("wind has no effect: no robot has an acceleration of G")));
}

TEST(KeysWithoutEffect, ADisturbanceNeedsAStateOrAnInputOfItsKind) {
  const std::string turns =
      "[simulation.disturbance]\nyaw_lag = 0.1\nslip = 0.1\nnoise = { heading = 0.1 }\n"
      "odometry = { heading_bias = 0.1 }\n";
  EXPECT_EQ(unused(point + turns).size(), 4u);
  EXPECT_THAT(unused(boat + turns), ElementsAre(HasSubstr("yaw_lag has no effect: no robot has one input"),
                                                HasSubstr("slip has no effect: no robot has wheels")));
  EXPECT_THAT(unused(rover + turns), IsEmpty());
  const std::string wakes = "[simulation.disturbance]\nairflow = { amplitude = 0.1 }\n";
  EXPECT_THAT(unused(multirotor + wakes), ElementsAre(HasSubstr("one robot alone")));
  EXPECT_THAT(unused(std::string(multirotor) + point + wakes), IsEmpty());
}

TEST(KeysWithoutEffect, AFloorNeedsARobotThatClimbsAndAMarginABarrier) {
  const std::string bounds = "[safety]\nfloor = -1.0\nceiling = 3.0\nmargin = 0.1\n";
  EXPECT_THAT(unused(rover + bounds), ElementsAre("safety.floor has no effect: no robot leaves its height",
                                                  "safety.ceiling has no effect: no robot leaves its height",
                                                  "safety.margin has no effect: the barrier is off"));
  EXPECT_THAT(unused(multirotor + bounds + "barrier = \"on\"\n"), IsEmpty());
  EXPECT_THAT(unused(std::string(multirotor) + "[safety.search]\nturn_after = 5.0\n"),
              ElementsAre(HasSubstr("safety.search has")));
}

TEST(KeysWithoutEffect, WhatAnotherKeySwitchesOnNeedsThat) {
  const std::string keys =
      "[simulation.disturbance]\ngust = { time = 2.0 }\nairflow = { distance = 1.0 }\n[estimate]\ntilt_time "
      "= 1.0\n"
      "[safety]\nposition_sigma = 0.1\nheading_sigma = 0.1\n";
  const std::string two =
      std::string(multirotor) + "[agent.other]\nrobot = \"multirotor\"\nstart = { p = [4.0, 0.0, 1.0] }\n";
  EXPECT_THAT(
      unused(two + keys),
      ElementsAre(HasSubstr("safety.position_sigma has"), HasSubstr("safety.heading_sigma has"),
                  HasSubstr("gust.time has"), HasSubstr("airflow.distance has"), HasSubstr("estimate has")));
  EXPECT_THAT(unused(two + "[simulation.disturbance]\ngust = { sigma = 1.0, time = 2.0 }\n"
                           "[safety]\nbarrier = \"on\"\nposition_sigma = 0.1\nheading_sigma = 0.1\n"),
              IsEmpty());
}

TEST(KeysWithoutEffect, WhatIsShippedHasNone) {
  for (const auto& entry : std::filesystem::directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find("\n[agent.") == std::string::npos) continue;
    EXPECT_THAT(keys_without_effect(read_scenario(entry.path())), IsEmpty()) << entry.path();
  }
}

}  // namespace
}  // namespace sightline
