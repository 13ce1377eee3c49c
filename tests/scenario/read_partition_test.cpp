#include "sightline/scenario/read_partition.hpp"

#include <gtest/gtest.h>

#include "sightline/scenario.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

const std::string four_robots = R"([safety]
barrier = "on"
[agent."a{0..3}"]
robot = "multirotor"
start.p = { each = [[0, 0, 1], [2, 0, 1], [4, 0, 1], [6, 0, 1]] }
[target.mark]
p = [9, 0, 1]
[[couple]]
potential = { too_near = { d_min = 1.0 } }
between = ["a1", "a2"]
[[couple]]
potential = { too_near = { d_min = 1.0 } }
between = ["a3", "mark"]
felt_by = ["a3"]
)";
const std::string halves = "[partition]\nleft = [\"a0\", \"a1\"]\nright = [\"a3\", \"a2\"]\n";

std::string partition_refusal(const std::string& partition) {
  return test::scenario_refusal(four_robots + partition);
}

TEST(Partition, SaysWhoIsPlannedTogetherAndHowMessagesGo) {
  const Scenario scenario =
      test::scenario_of(four_robots + halves + "[partition.exchange]\nloss = 0.2\ndelay = 0.03\n");
  ASSERT_TRUE(scenario.partition.has_value());
  const PartitionPlan& plan = *scenario.partition;
  ASSERT_EQ(plan.parts.size(), 2u);
  EXPECT_EQ(plan.parts[1].robots, (std::vector<std::string>{"a3", "a2"}));
  EXPECT_EQ(plan.exchange.loss, 0.2);
  EXPECT_EQ(plan.exchange.seed, scenario.simulation.seed);
  EXPECT_FALSE(plan.apart());
  const Controls controls(scenario);
  EXPECT_EQ(controls.controllers()[0].get().name(), "partitioned");
  EXPECT_NE(summary(scenario).find("part        left: a0, a1\n"), std::string::npos);
}

TEST(Partition, ByOneSolverWhereItSaysAll) {
  const Scenario scenario = test::scenario_of(four_robots + halves + "part = \"all\"\n");
  EXPECT_EQ(scenario.team.agents().size(), 4u);
  EXPECT_EQ(Controls(scenario).controllers()[0].get().name(), "newton_riccati");
}

TEST(Partition, OfAPartTheOthersAreBodiesThatItSees) {
  const Scenario scenario =
      test::scenario_of(four_robots + halves + "part = \"right\"\n[partition.exchange]\nspeed_max = 2.0\n");
  const Team& team = scenario.team;
  ASSERT_EQ(team.agents().size(), 2u);
  EXPECT_EQ(team.bodies(), 5);
  EXPECT_FALSE(team.is_agent(team.find("a1")));
  EXPECT_EQ(scenario.targets, (std::vector{team.find("mark")}));
  EXPECT_EQ(scenario.obstacles.size(), 2u);
  EXPECT_EQ(team.couplings().size(), 2u) << "a2 feels a1, a3 the mark";
  EXPECT_EQ(scenario.coupling_places.size(), 2u);
  const auto place = [&](std::string_view name) {
    return scenario.x0[at(team.state_offset(team.find(name)))];
  };
  EXPECT_EQ(place("a0"), 0.0);
  EXPECT_EQ(place("a1"), 2.0);
  EXPECT_EQ(place("a2"), 4.0);
  EXPECT_EQ(place("mark"), 9.0);
  const auto& others = scenario.uncooperative;
  const auto a1 = std::find_if(others.begin(), others.end(),
                               [&](const UncooperativeBody& body) { return body.body == team.find("a1"); });
  ASSERT_NE(a1, others.end());
  EXPECT_EQ(a1->robot, "multirotor");
  EXPECT_EQ(a1->speed_max, 2.0);
  // From its own text it is the same again.
  EXPECT_EQ(test::scenario_of(scenario.text).team.bodies(), 5);
}

TEST(Partition, PutsEveryRobotIntoOnePartText) {
  EXPECT_EQ(partition_refusal("[partition]\nleft = [\"a0\", \"a1\"]\n"),
            "a.toml:15: partition = {...}, expected every robot in one part, a2 is in none");
  EXPECT_EQ(partition_refusal("[partition]\nleft = [\"a0\", \"a1\"]\nright = [\"a2\", \"a3\", \"a0\"]\n"),
            "a.toml:17: partition.right[2] = \"a0\", expected a robot that no part has yet");
  EXPECT_EQ(partition_refusal("[partition]\nleft = [\"b0\"]\n"),
            "a.toml:16: partition.left[0] = \"b0\", expected a robot: a0, a1, a2, a3");
  EXPECT_EQ(partition_refusal("[partition]\nleft = []\n"),
            "a.toml:16: partition.left = [], expected an array of one or more robots by name");
  EXPECT_EQ(partition_refusal("[partition]\n"),
            "a.toml:15: partition = {}, expected a part, as front = [\"uav0\"]");
  EXPECT_EQ(partition_refusal(halves + "part = \"middle\"\n"),
            "a.toml:18: partition.part = \"middle\", expected one of \"all\", \"left\", \"right\"");
  EXPECT_EQ(partition_refusal(halves + "[partition.exchange]\nloss = 1.5\n"),
            "a.toml:19: partition.exchange.loss = 1.5, expected 0 to 1");
  EXPECT_NE(partition_refusal("[partition]\nall = [\"a0\", \"a1\", \"a2\", \"a3\"]\n"), "");
  EXPECT_NE(partition_refusal("[partition]\n\"a b\" = [\"a0\", \"a1\", \"a2\", \"a3\"]\n"), "");
}

TEST(Partition, RefusesWhatPartsCannotFly) {
  EXPECT_EQ(partition_refusal(halves + "[solver]\nname = \"cgmres\"\n"),
            "a.toml:15: partition: the solver cgmres cannot plan a part, expected newton_riccati");
  EXPECT_EQ(partition_refusal(halves + "[target.late]\np = [20, 0, 1]\npresent = false\n"),
            "a.toml:15: partition: the team changes in flight, expected a scenario without events");
  EXPECT_NE(partition_refusal(
                halves +
                "[[keep_apart]]\nagents = [\"a0\", \"a2\"]\npotential = { too_near = {} }\nradius = 2.0\n"),
            "");
}

}  // namespace
}  // namespace sightline
