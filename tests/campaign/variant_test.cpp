#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/analysis.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

const std::string text = R"([agent.seer]  # looks
robot = "multirotor"
start = { p = [9.0, 9.0, 9.0], heading = 0.5, v = [0.1, 0.2] }
[agent.seer.sensor]
pitch = 0.5
[agent.seen]
robot = "multirotor"
start = { p = [1.0, 2.0, 3.0], heading = 0.0 }
reference = { circle = { centre = [0.0, 0.0, 1.0], radius = 0.5, rate = 0.3 } }
[obstacle.box]
p = [5.0, 5.0, 0.0]
[[couple]]
potential = { bearing = { alpha = 0.5, width = 0.1, tilt = 0.2 } }
between = ["seer", "seen"]
weight = 1.0
[simulation]
duration = 60.0
seed = 3
compare = ["cgmres"]
)";

Distribution always(double value) {
  return {.kind = Distribution::Kind::choice, .values = {value}, .fractions = {1.0}};
}

StartDraw start(double range, double bearing, double height) {
  return {.agent = "seer",
          .around = "seen",
          .range = always(range),
          .bearing = always(bearing),
          .height = always(height)};
}

Scenario variant(const CampaignPlan& plan, int index = 0) {
  return Variants(parse_scenario(text, "some.toml"), plan).of(draw_run(plan, 1, index));
}

TEST(Variant, AStartLiesWhereRangeBearingAndHeightSay) {
  for (const double heading : {0.0, 1.0, -3.0}) {
    for (const double range : {0.0, 0.5, 4.0}) {
      for (double bearing = -3.0; bearing <= 3.0; bearing += 0.5) {
        CampaignPlan plan;
        plan.starts = {start(range, bearing, -0.75)};
        plan.starts[0].heading = always(heading);
        const Scenario made = variant(plan);
        const std::vector<double>& x = made.x0;
        EXPECT_NEAR(x[2], 3.0 - 0.75, 1e-12);
        EXPECT_NEAR(std::hypot(1.0 - x[0], 2.0 - x[1]), range, 1e-12);
        EXPECT_NEAR(x[3], std::cos(heading), 1e-12);
        EXPECT_NEAR(x[4], std::sin(heading), 1e-12);
        if (range == 0) continue;
        const double seen_at = std::atan2(2.0 - x[1], 1.0 - x[0]);
        EXPECT_NEAR(std::remainder(seen_at - heading - bearing, 2 * pi), 0.0, 1e-12);
      }
    }
  }
}

TEST(Variant, ExactlyBehindIsExactlyBehind) {
  for (const double behind : {pi, -pi}) {
    CampaignPlan plan;
    plan.starts = {start(2.0, behind, 0.0)};
    plan.starts[0].heading = always(0.0);
    EXPECT_EQ(variant(plan).x0[0], 3.0);
    EXPECT_EQ(variant(plan).x0[1], 2.0);
  }
}

TEST(Variant, WhatIsNotDrawnStaysAsItWas) {
  CampaignPlan plan;
  plan.starts = {start(1.0, 0.0, 0.0)};
  const Scenario made = variant(plan), base = parse_scenario(text, "some.toml");
  EXPECT_EQ(made.x0[3], base.x0[3]);
  EXPECT_EQ(made.x0[5], 0.1);
  EXPECT_EQ(made.x0[6], 0.2);
  EXPECT_TRUE(std::equal(made.x0.begin() + 7, made.x0.end(), base.x0.begin() + 7));
  EXPECT_THAT(made.text, testing::StartsWith("[agent.seer]  # looks\nrobot = \"multirotor\"\n"));
}

TEST(Variant, VelocitiesAndNumbersReachTheirPlaces) {
  CampaignPlan plan;
  plan.starts = {start(1.0, 0.0, 0.0)};
  plan.starts[0].velocity = Distribution{.values = {0.25, 0.75}};
  plan.draws = {{"couple[0].weight", always(7.5)}, {"obstacle.box.p[2]", always(1.25)}};
  const RunDraw run = draw_run(plan, 1, 4);
  const Scenario made = variant(plan, 4);
  EXPECT_EQ(made.x0[5], run.values[3]);
  EXPECT_EQ(made.x0[6], run.values[4]);
  EXPECT_EQ(made.team.couplings()[0].term.weight, 7.5);
  EXPECT_EQ(made.x0[16], 1.25);
}

TEST(Variant, WhatFollowsFromADrawnNumberIsItTimesAPlusB) {
  CampaignPlan plan;
  plan.draws = {
      {"obstacle.box.p[1]", always(4.0), {{"obstacle.box.p[2]", 0.5, 1.0}, {"agent.seen.start.p[0]"}}},
      {"obstacle.box.p[0]", always(7.0)}};
  const Scenario made = variant(plan);
  const std::vector<double> box(made.x0.begin() + 14, made.x0.begin() + 17);
  EXPECT_EQ(box, (std::vector<double>{7.0, 4.0, 3.0}));
  EXPECT_EQ(made.x0[7], 4.0);
}

TEST(Variant, AStartIsAroundTheBodysOwnDrawnPlace) {
  for (const char* around : {"seen", "box"}) {
    CampaignPlan plan;
    plan.starts = {start(1.0, 0.5, 0.5)};
    plan.starts[0].around = around;
    const std::string key = around == std::string("seen") ? "agent.seen.start.p" : "obstacle.box.p";
    plan.draws = {{key + "[0]", always(20.0)}, {key + "[2]", always(2.0)}};
    const Scenario made = variant(plan);
    EXPECT_NEAR(std::hypot(made.x0[0] - 20.0, made.x0[1] - (key[0] == 'a' ? 2.0 : 5.0)), 1.0, 1e-12);
    EXPECT_EQ(made.x0[2], 2.5);
  }
}

TEST(Variant, ItsTextAloneIsTheSameScenario) {
  CampaignPlan plan;
  plan.duration = 12.5;
  plan.starts = {start(1.0, 2.0, 0.0)};
  plan.draws = {{"agent.seen.reference.circle.rate", Distribution{.values = {0.1, 0.9}}}};
  const Scenario made = variant(plan, 3), read = parse_scenario(made.text, "some.toml");
  EXPECT_EQ(read.x0, made.x0);
  EXPECT_EQ(read.simulation.duration, 12.5);
  EXPECT_EQ(made.simulation.duration, 12.5);
  EXPECT_EQ(read.simulation.seed, draw_run(plan, 1, 3).seed);
  EXPECT_EQ(made.simulation.seed, read.simulation.seed);
  EXPECT_TRUE(made.simulation.compare.empty());
  EXPECT_EQ(made.name, "some");
}

TEST(Variant, OnlyWhatTheTeamIsMadeOfAsksForAnotherSolver) {
  CampaignPlan plan;
  plan.starts = {start(1.0, 2.0, 0.0)};
  plan.draws = {{"agent.seen.reference.circle.rate", always(0.5)},
                {"agent.seen.start.p[0]", always(1.5)},
                {"obstacle.box.p[0]", always(2.5)},
                {"couple[0].weight", always(3.5)}};
  const Variants variants(parse_scenario(text, "some.toml"), plan);
  EXPECT_THAT(variants.team_values(draw_run(plan, 1, 0)), testing::ElementsAre(0.5, 3.5));
}

TEST(Variant, ANumberThatIsNotThereOrOutOfItsRangeIsRefusedAtItsLine) {
  CampaignPlan plan;
  plan.draws = {{"couple[1].weight", always(1.0)}};
  EXPECT_THAT(refusal_of<ScenarioError>([&] { Variants(parse_scenario(text, "some.toml"), plan); }),
              testing::StartsWith("some.toml:1: couple[1].weight is missing, expected the number"));
  plan.draws = {{"couple[0].weight", always(-1.0)}};
  EXPECT_THAT(refusal_of<ScenarioError>([&] { variant(plan); }),
              testing::StartsWith("some.toml:15: couple[0].weight = -1"));
}

TEST(Variant, NumbersOfATemplateAreDrawnForAllThatAreLikeIt) {
  const std::string of_template = R"(
[template.t]
robot = "multirotor"
R = [0.5, 0.5, 0.5, 0.5]
[agent."r{0..1}"]
inherits = "t"
start = { p = { place = "line", from = [0.0, 0.0, 1.0], to = [3.0, 0.0, 1.0] } }
[campaign]
duration = 5.0
[[campaign.draw]]
key = "template.t.R[1]"
uniform = [0.4, 0.6]
)";
  const Scenario scenario = parse_scenario(of_template, "team.toml");
  ASSERT_TRUE(scenario.campaign);
  const Variants variants(scenario, *scenario.campaign);
  const RunDraw run = draw_run(*scenario.campaign, 1, 0);
  const Scenario drawn = variants.of(run);
  for (const Agent& agent : drawn.team.agents()) EXPECT_EQ(agent.R[1], run.values[0]);
}

TEST(Variant, AFlightIsTheRunWithoutTheCampaign) {
  const std::string campaign = R"(
[campaign]  # a comment
duration = 5.0
[[campaign.start]]
agent = "seer"
around = "seen"
range = { uniform = [0.5,
  6.0] }
bearing = { constant = 1.0, fraction = 0.5, uniform = [-1.0, 1.0] }
height = { uniform = [0.0, 1.0] }
)",
                    drawn = R"(
[[campaign.draw]]
key = "agent.seen.start.p[0]"
uniform = [1.0, 2.0]
)";
  // In one piece, in two, and inline, without a header.
  for (const std::string& whole :
       {text + campaign + drawn, campaign + text + drawn,
        "campaign = { draw = [{ key = \"agent.seen.start.p[0]\", uniform = [1.0, 2.0] }] }\n" + text}) {
    const Scenario scenario = parse_scenario(whole, "some.toml");
    ASSERT_TRUE(scenario.campaign);
    const Variants variants(scenario, *scenario.campaign);
    const RunDraw run = draw_run(*scenario.campaign, 1, 3);
    const Scenario made = variants.of(run), flight = variants.flight(run);
    EXPECT_EQ(made.text.size(), flight.text.size());
    EXPECT_EQ(std::count(made.text.begin(), made.text.end(), '\n'),
              std::count(flight.text.begin(), flight.text.end(), '\n'));
    EXPECT_TRUE(made.campaign);
    EXPECT_EQ(flight.campaign.has_value(), whole.starts_with("campaign"));
    EXPECT_EQ(made.x0, flight.x0);
    EXPECT_EQ(made.simulation.seed, flight.simulation.seed);
    EXPECT_EQ(made.team.couplings().size(), flight.team.couplings().size());
    EXPECT_EQ(made.text.find("[simulation]"), flight.text.find("[simulation]"));
  }
}

/// The same team as vehicles whose numbers only their presets say, with a campaign.
Scenario of_vehicles(const std::string& campaign) {
  return parse_scenario(
      text + "[world]\nkind = \"rotors\"\n[agent.seen.vehicle]\npreset = \"crazyflie\"\n[campaign]\n" +
          campaign,
      "some.toml");
}

TEST(Variant, ANumberThatTheFileDoesNotWriteIsAddedToIt) {
  const Scenario base = of_vehicles(
      "[[campaign.draw]]\nkey = \"agent.seer.vehicle.mass\"\nuniform = [1.9, 2.3]\n"
      "also = [{ key = \"agent.seen.vehicle.mass\", times = 0.015 }, { key = \"agent.seer.command_delay\", "
      "times = 0.05 }]\n"
      "[[campaign.draw]]\nkey = \"agent.seen.vehicle.tau_up\"\nchoice = [0.01, 0.02]\n");
  ASSERT_TRUE(base.campaign);
  const Variants variants(base, *base.campaign);
  for (int index = 0; index < 5; ++index) {
    const RunDraw run = draw_run(*base.campaign, 1, index);
    const Scenario made = variants.of(run);
    ASSERT_EQ(made.vehicles.size(), 2u);
    EXPECT_EQ(made.vehicles[0].vehicle.mass, run.values[0]);
    EXPECT_EQ(made.vehicles[1].vehicle.mass, 0.015 * run.values[0]);
    EXPECT_EQ(made.vehicles[1].vehicle.tau_up, run.values[1]);
    ASSERT_EQ(made.compensations.size(), 1u);
    EXPECT_EQ(made.compensations[0].command_delay, 0.05 * run.values[0]);
    EXPECT_EQ(made.vehicles[0].vehicle.k_f, base.vehicles[0].vehicle.k_f) << "the others stay the preset's";
    EXPECT_EQ(parse_scenario(made.text, "some.toml").vehicles[0].vehicle.mass, run.values[0])
        << "its text says it";
  }
}

TEST(Variant, AVehiclesNumbersNeedNoSolverOfTheirOwn) {
  const Scenario base = of_vehicles(
      "[[campaign.draw]]\nkey = \"agent.seer.vehicle.mass\"\nuniform = [1.9, 2.3]\n"
      "[[campaign.draw]]\nkey = \"couple[0].weight\"\nuniform = [1.0, 2.0]\n");
  const RunDraw run = draw_run(*base.campaign, 1, 0);
  EXPECT_EQ(Variants(base, *base.campaign).team_values(run), std::vector<double>{run.values[1]});
}

TEST(Variant, WindIsDrawnBySizeAndDirection) {
  const Scenario base = of_vehicles(
      "[[campaign.draw]]\nkey = \"simulation.disturbance.wind.size\"\nuniform = [0.2, 1.0]\n"
      "[[campaign.draw]]\nkey = \"simulation.disturbance.wind.direction\"\nuniform = [-3.0, 3.0]\n");
  const RunDraw run = draw_run(*base.campaign, 1, 3);
  const Vec3<double> wind = Variants(base, *base.campaign).of(run).simulation.disturbances.wind;
  EXPECT_NEAR(norm(wind), run.values[0], 1e-12);
  EXPECT_NEAR(std::atan2(wind.y, wind.x), run.values[1], 1e-12);
}

TEST(Variant, ANumberThatAnotherScenarioCannotTakeIsRefusedBeforeARun) {
  const Scenario base =
      of_vehicles("[[campaign.draw]]\nkey = \"agent.seer.vehicle.mass\"\nuniform = [1.9, 2.3]\n");
  EXPECT_THROW(Variants(parse_scenario(text, "other.toml"), *base.campaign), ScenarioError);
}

}  // namespace
}  // namespace sightline
