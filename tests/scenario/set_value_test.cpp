#include "sightline/scenario/set_value.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

const std::string team_text = R"([agent.a]
robot = "multirotor"
start = { p = [0, 0, 1], heading = 0.0 }
[agent.b]
robot = "multirotor"
start = { p = [2, 0, 1], heading = 0.0 }
[[couple]]
potential = { keep_out = { d_min = 1.0 } }
between = ["a", "b"]
weight = 0.4
)";

Scenario with_set(const std::vector<std::string>& set) {
  return parse_scenario(team_text, "team.toml", built_in_registry(), {.files = {}, .set = set});
}

std::string set_refusal(const std::string& assignment) {
  return refusal_of<ScenarioError>([&] { with_set({assignment}); });
}

TEST(SetValue, PutsAValueWhereAnotherStoodOrNoneDid) {
  const Scenario scenario = with_set({"couple[0].weight=0.5", "horizon.stages = 7", "agent.b.start.p[2]=3",
                                      "solver.name=\"cgmres\"", "agent.a.R=[1, 2, 3, 4]"});
  EXPECT_EQ(scenario.team.couplings()[0].term.weight, 0.5);
  EXPECT_EQ(scenario.horizon.N, 7);
  EXPECT_EQ(scenario.x0[9], 3.0);
  EXPECT_EQ(scenario.solver.name, "cgmres");
  EXPECT_EQ(scenario.team.agents()[0].R, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(summary(parse_scenario(scenario.text, "team.toml")), summary(scenario))
      << "the text says what is set";
}

TEST(SetValue, AWordThatIsNoValueIsAText) {
  const Scenario scenario = with_set(
      {"world.kind=rotors", "agent.a.vehicle.preset=x500", "agent.b.vehicle={ preset = \"crazyflie\" }"});
  EXPECT_EQ(scenario.world, "rotors");
  ASSERT_EQ(scenario.vehicles.size(), 2u);
  EXPECT_EQ(scenario.vehicles[0].preset, "x500");
  EXPECT_EQ(scenario.vehicles[1].preset, "crazyflie");
  EXPECT_EQ(set_refusal("agent.a.present=maybe"),
            "--set agent.a.present=maybe: agent.a.present = \"maybe\", expected true or false");
  EXPECT_THAT(
      set_refusal("agent.a.vehicle.mass=1"),
      testing::StartsWith("--set agent.a.vehicle.mass=1: agent.a.vehicle = {...}, expected no such table"));
}

TEST(SetValue, WhatIsNoAssignmentIsRefusedInOneLine) {
  for (const char* bad :
       {"", "=", "=1", "horizon.stages", "horizon..stages=1", "horizon.stages=", "a[=1", "a[x]=1", "a]=1",
        "horizon.stages=1\nb=2", "horizon.stages=[1", "couple[0]x=1", "a.\"b=1", "horizon.stages=1 2"}) {
    const std::string sentence = set_refusal(bad);
    EXPECT_THAT(sentence, testing::StartsWith("--set ")) << bad;
    EXPECT_THAT(sentence, testing::HasSubstr("expected")) << bad;
    EXPECT_THAT(sentence, testing::Not(testing::HasSubstr("\n"))) << bad;
  }
}

TEST(SetValue, PlacesThatCannotBeAreToldWithWhatCan) {
  EXPECT_THAT(set_refusal("couple[1].weight=1"), testing::HasSubstr("a place in [0, 1)"));
  EXPECT_THAT(set_refusal("horizon[0]=1"), testing::HasSubstr("a key that holds an array"));
  EXPECT_THAT(set_refusal("couple[0].weight.x=1"), testing::HasSubstr("a key of a table"));
}

}  // namespace
}  // namespace sightline
