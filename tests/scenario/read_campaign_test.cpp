#include "sightline/scenario/read_campaign.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"

namespace sightline {
namespace {

const std::string robots = R"([agent.uav0]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0, v = [0.0, 0.0] }
[target.tag]
p = [1.0, 0.0, 1.0]
)";

CampaignPlan plan(const std::string& text) {
  const Scenario scenario = parse_scenario(robots + text, "a");
  if (scenario.campaign_refusal) throw ScenarioError(*scenario.campaign_refusal);
  return *scenario.campaign;
}

TEST(ReadCampaign, AScenarioWithoutTheSectionHasNoCampaign) {
  EXPECT_FALSE(parse_scenario(robots, "a").campaign.has_value());
}

TEST(ReadCampaign, WhatIsLeftOutIsAsInTheStruct) {
  const CampaignPlan read = plan("[campaign]\n"), built;
  EXPECT_EQ(read.duration, built.duration);
  EXPECT_EQ(read.view_within, built.view_within);
  EXPECT_EQ(read.d_hard, built.d_hard);
  EXPECT_EQ(read.braking, built.braking);
  EXPECT_TRUE(read.starts.empty() && read.draws.empty());
}

TEST(ReadCampaign, EachKeyReachesThePlan) {
  const CampaignPlan read = plan(R"([campaign]
duration = 12.0
view_within = 8.0
d_hard = 0.75
braking = 0.5
[[campaign.start]]
agent = "uav0"
around = "tag"
range = { uniform = [0.5, 2.0] }
bearing = { normal = [0.1, 0.2], constant = 3.0, fraction = 0.25 }
height = { choice = [1.0, 2.0, 3.0] }
heading = { uniform = [-1.0, 1.0] }
v = { choice = [0.0, 0.5], fractions = [0.25, 0.75] }
[[campaign.draw]]
key = "target.tag.p[2]"
uniform = [0.0, 2.0]
)");
  EXPECT_EQ(read.duration, 12.0);
  EXPECT_EQ(read.view_within, 8.0);
  EXPECT_EQ(read.d_hard, 0.75);
  EXPECT_EQ(read.braking, 0.5);
  ASSERT_EQ(read.starts.size(), 1U);
  const StartDraw& start = read.starts[0];
  EXPECT_EQ(start.agent, "uav0");
  EXPECT_EQ(start.around, "tag");
  EXPECT_EQ(start.range.kind, Distribution::Kind::uniform);
  EXPECT_THAT(start.range.values, testing::ElementsAre(0.5, 2.0));
  EXPECT_EQ(start.bearing.kind, Distribution::Kind::normal);
  EXPECT_THAT(start.bearing.values, testing::ElementsAre(0.1, 0.2));
  EXPECT_EQ(start.bearing.constant, 3.0);
  EXPECT_EQ(start.bearing.fraction, 0.25);
  EXPECT_EQ(start.height.kind, Distribution::Kind::choice);
  EXPECT_THAT(start.height.fractions, testing::Each(testing::DoubleEq(1.0 / 3.0)));
  EXPECT_THAT(start.heading->values, testing::ElementsAre(-1.0, 1.0));
  EXPECT_THAT(start.velocity->fractions, testing::ElementsAre(0.25, 0.75));
  ASSERT_EQ(read.draws.size(), 1U);
  EXPECT_EQ(read.draws[0].key, "target.tag.p[2]");
  EXPECT_THAT(read.draws[0].distribution.values, testing::ElementsAre(0.0, 2.0));
}

// Of all that [campaign] may say, nothing is of use to a flight that is no campaign's.
TEST(ReadCampaign, WhatIsWrongWithItStopsNoOtherFlight) {
  for (const char* wrong :
       {"[campaign]\nruns = 100\n", "[campaign]\nduration = -1.0\n",
        "[campaign]\n[[campaign.draw]]\nkey = \"agent.uav0.start.q[0]\"\nuniform = [0.0, 1.0]\n",
        "[campaign]\n[[campaign.start]]\nagent = \"uav9\"\n", "[campaign.evasion]\nagent = \"uav9\"\n",
        "campaign = 3\n"}) {
    const bool is_key = wrong[0] == 'c';
    const Scenario scenario = parse_scenario(is_key ? wrong + robots : robots + wrong, "a");
    EXPECT_EQ(scenario.team.bodies(), 2) << wrong;
    EXPECT_FALSE(scenario.campaign) << wrong;
    ASSERT_TRUE(scenario.campaign_refusal) << wrong;
    EXPECT_THAT(scenario.campaign_refusal->what(), testing::HasSubstr("expected")) << wrong;
  }
}

// The drawn number would be a comment behind another value.
TEST(ReadCampaign, AKeySetsNothingButTheNumberThatIsDrawn) {
  for (const char* key : {R"(solver.name=\"cgmres\" #)", "horizon.stages=3 #", "simulation.seed=1", "a=b.c"})
    EXPECT_THROW(
        plan(fmt::format("[campaign]\n[[campaign.draw]]\nkey = \"{}\"\nuniform = [1.0, 2.0]\n", key)),
        ScenarioError)
        << key;
}

}  // namespace
}  // namespace sightline
