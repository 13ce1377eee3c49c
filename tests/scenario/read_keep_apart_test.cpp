#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_coupling.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

constexpr std::string_view three_robots =
    "[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n"
    "[agent.b]\nrobot = \"multirotor\"\nstart = { p = [2, 0, 1] }\n"
    "[agent.c]\nrobot = \"multirotor\"\nstart = { p = [4, 0, 1] }\n"
    "[obstacle.o]\np = [9, 0, 1]\n";

Scenario keeping_apart(std::string_view keys) {
  return parse_scenario(fmt::format("{}[[keep_apart]]\n{}\n", three_robots, keys), "a.toml");
}

std::string keep_apart_refusal(std::string_view keys) {
  return refusal_of<ScenarioError>([&] { keeping_apart(keys); });
}

TEST(ReadKeepApart, EachKeyReachesTheSwarm) {
  const Scenario scenario = keeping_apart(
      "agents = [\"c\", \"a\"]\nradius = 3\npotential = { pass_right = { d_min = 1.1 } }\nweight = "
      "2\npairs_max = 1");
  ASSERT_EQ(scenario.team.swarms().size(), 1U);
  const Swarm& swarm = scenario.team.swarms()[0];
  EXPECT_EQ(swarm.agents, (std::vector<AgentId>{{{2}}, {{0}}}));
  EXPECT_EQ(swarm.radius, 3.0);
  EXPECT_EQ(swarm.capacity, 1);
  EXPECT_EQ(swarm.term.weight, 2.0);
  ASSERT_NE(swarm.term.potential.as<PassRight>(), nullptr);
  EXPECT_EQ(swarm.term.potential.as<PassRight>()->d_min, 1.1);
}

TEST(ReadKeepApart, AllAreAllRobotsAndThereIsRoomForAllPairs) {
  const Scenario scenario = keeping_apart("agents = \"all\"\npotential = { too_near = {} }");
  const Swarm& swarm = scenario.team.swarms().at(0);
  EXPECT_EQ(swarm.agents.size(), 3U);
  EXPECT_EQ(swarm.radius, 2.5);
  EXPECT_EQ(swarm.capacity, 3);
  EXPECT_EQ(swarm.term.weight, 1.0);
}

TEST(ReadKeepApart, ALargeTeamHasRoomForThirtyPairsOfEachRobot) {
  const Scenario scenario = parse_scenario(
      "[agent.\"uav{000..199}\"]\nrobot = \"multirotor\"\n"
      "start = { p = { place = \"circle\", centre = [0, 0, 1], radius = 40 } }\n"
      "[[keep_apart]]\nagents = \"all\"\npotential = { too_near = {} }\n",
      "a.toml");
  EXPECT_EQ(scenario.team.swarms().at(0).capacity, 6000);
  EXPECT_EQ(scenario.log.prediction_period, 0.2) << "a thousand predictions a second";
}

TEST(ReadKeepApart, WhatIsWrongIsRefusedWithItsPlace) {
  const std::string rest = "potential = { too_near = {} }";
  EXPECT_EQ(keep_apart_refusal(rest),
            "a.toml:12: keep_apart[0].agents is missing, expected \"all\" or a list of names");
  EXPECT_EQ(keep_apart_refusal("agents = \"some\"\n" + rest),
            "a.toml:13: keep_apart[0].agents = \"some\", expected \"all\" or a list of names");
  EXPECT_EQ(keep_apart_refusal("agents = [\"a\", \"d\"]\n" + rest),
            "a.toml:13: keep_apart[0].agents[1] = \"d\", expected a robot: a, b, c");
  EXPECT_THAT(keep_apart_refusal("agents = [\"a\", \"o\"]\n" + rest), testing::HasSubstr("expected a robot"));
  EXPECT_THAT(keep_apart_refusal("agents = [\"a\", \"a\"]\n" + rest),
              testing::HasSubstr("expected each robot once"));
  EXPECT_THAT(keep_apart_refusal("agents = [\"a\"]\n" + rest), testing::HasSubstr("expected at least two"));
  EXPECT_THAT(keep_apart_refusal("agents = \"all\"\nradius = 1.2\n" + rest),
              testing::HasSubstr("at the radius of 1.2 m"));
  EXPECT_THAT(keep_apart_refusal("agents = \"all\"\npairs_max = 0\n" + rest),
              testing::HasSubstr("pairs_max = 0"));
  EXPECT_THAT(keep_apart_refusal("agents = \"all\"\nroom = 1\n" + rest), testing::HasSubstr("room"));
  EXPECT_THAT(keep_apart_refusal("agents = \"all\"\npotential = { relative_velocity = {} }"),
              testing::HasSubstr("depends on more than"));
}

}  // namespace
}  // namespace sightline
