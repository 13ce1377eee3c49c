#include "sightline/scenario/reach.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/robots.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Reach, IsWhatTheInputsOfARobotChange) {
  EXPECT_THAT(reach_of(Model(Multirotor{})),
              ElementsAre(true, true, true, true, true, true, true, true, true, true));
  EXPECT_THAT(reach_of(Model(OmniRover{})),
              ElementsAre(true, true, false, true, true, true, true, false, false, false));
  EXPECT_THAT(reach_of(Model(PointMass{})),
              ElementsAre(true, true, true, false, false, true, true, true, true, true));
}

/// Two robots on the ground and in the air, with a limit between them that some feel.
std::vector<std::string> influence_warnings(const std::string& inside, const std::string& felt_by,
                                            const std::string& more = "") {
  return limits_beyond_influence(parse_scenario(fmt::format(R"(
[agent.rover]
robot = "omni_rover"
start = {{ p = [0.0, 0.0, 0.0], heading = 0.0 }}
sensor = {{ pitch = 0.0 }}
[agent.uav]
robot = "multirotor"
start = {{ p = [1.0, 0.0, 1.0], heading = 0.0 }}
[[couple]]
between = ["rover", "uav"]
felt_by = ["{}"]
[couple.potential.region]
inside = "{}"
slope = {{ softplus = {{}} }}
{})",
                                                            felt_by, inside, more),
                                                "team.toml"));
}

TEST(LimitsBeyondInfluence, ALimitOnTheTargetAloneThatItsObserverFeelsIsToldWithWhoCouldKeepIt) {
  const auto sentences = influence_warnings("target.v_x < 0.5 m/s", "rover");
  ASSERT_EQ(sentences.size(), 1u);
  EXPECT_THAT(sentences[0], HasSubstr("couple[0] region depends on v_x of uav, which rover cannot change"));
  EXPECT_THAT(sentences[0], HasSubstr("felt_by = [\"uav\"]"));
  EXPECT_THAT(influence_warnings("target.v_x < 0.5 m/s", "uav"), IsEmpty());
}

TEST(LimitsBeyondInfluence, AHeightIsBeyondARoverAndWithinAMultirotor) {
  EXPECT_EQ(influence_warnings("r_z < 0.5 m", "rover").size(), 1u);
  EXPECT_THAT(influence_warnings("r_z < 0.5 m", "uav"), IsEmpty());
  EXPECT_THAT(influence_warnings("distance < 2 m", "rover"), IsEmpty());
}

TEST(LimitsBeyondInfluence, TimeAloneIsInNobodySHands) {
  EXPECT_THAT(influence_warnings("t < 5 s", "uav").at(0), HasSubstr("no pose and no velocity"));
}

TEST(LimitsBeyondInfluence, ThoseOfConstraintsAndEventsAreToldToo) {
  EXPECT_THAT(influence_warnings("distance < 2 m", "rover",
                                 "[[constrain]]\nagent = \"rover\"\npotential = { altitude_band = {} }\n")
                  .at(0),
              HasSubstr("constrain[0] altitude_band depends on p_z of rover"));
  EXPECT_THAT(
      influence_warnings(
          "distance < 2 m", "rover",
          "[[event]]\nat = 1.0\nadd = { couple = { between = [\"rover\", \"uav\"], felt_by = [\"rover\"], "
          "potential = { region = { inside = \"target.p_x < 1 m\" } } } }\n")
          .size(),
      1u);
}

TEST(RobotsBeyondNoise, ARobotWithoutAVelocityIsToldAndOneWithItIsNot) {
  const auto scenario = [](const char* rate) {
    return parse_scenario(fmt::format(R"(
[agent.car]
start = {{ p = [0.0, 0.0, 0.0] }}
[agent.car.robot.text]
states = ["east", "north", "up", "speed"]
inputs = ["push", "side"]
position = ["east", "north", "up"]
f.east = "{}"
f.north = "side"
f.up = 0
f.speed = "push"
[simulation.disturbance]
noise = {{ velocity = 0.1, position = 0.1 }}
)",
                                      rate),
                          "car.toml");
  };
  EXPECT_THAT(robots_beyond_noise(scenario("speed")), IsEmpty());
  EXPECT_THAT(robots_beyond_noise(scenario("2 * speed")),
              ElementsAre("no state of car (text) is a velocity [m/s]: noise.velocity does not reach it"));
}

}  // namespace
}  // namespace sightline
