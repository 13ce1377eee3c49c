#include "sightline/scenario/read_safety.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

constexpr const char* bodies = R"(
[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0] }
[agent.b]
robot = "multirotor"
start = { p = [3.0, 0.0, 1.0] }
[target.t]
p = [6.0, 0.0, 1.0]
[obstacle.o]
p = [9.0, 0.0, 1.0]
v = [0.1, 0.0, 0.0]
speed_max = 0.4
d_hard = 1.2
)";

Scenario with_bodies(const std::string& text) { return test::scenario_of(bodies + text); }

TEST(ReadSafety, WithoutASectionNothingGuardsTheLoop) {
  const Scenario scenario = with_bodies("");
  EXPECT_FALSE(scenario.safety);
  EXPECT_FALSE(guard_options(scenario));
  EXPECT_FALSE(guard_options(with_bodies("[safety]\nd_hard = 0.6\n"))) << "it only judges";
}

TEST(ReadSafety, EachKeyReachesItsOption) {
  const Scenario scenario = with_bodies(R"(
[safety]
barrier = "on"
d_hard = 0.7
floor = 0.2
ceiling = 8.0
world = 50.0
residual_acceleration = 0.2
margin = 0.01
position_sigma = 0.03
heading_sigma = 0.04
[safety.supervisor]
fresh = 0.03
slow_after = 0.21
hold_after = 0.51
land_after = 2.1
sigma_hold = 0.8
sigma_land = 1.8
slow_factor = 0.4
land_speed = 0.2
ground = 0.1
brake_time = 0.5
v_max = 6.0
turn_max = 3.0
frozen_after = 0.4
accept_after = 5
[safety.search]
predict = 4.0
back_off = 0.5
sweep_from = 0.4
rate = 1.2
turn_after = 7.0
)");
  const auto guard = guard_options(scenario);
  ASSERT_TRUE(guard);
  EXPECT_EQ(guard->barrier, BarrierMode::on);
  EXPECT_EQ(guard->barrier_options.floor, 0.2);
  EXPECT_EQ(guard->barrier_options.ceiling, 8.0);
  EXPECT_EQ(guard->barrier_options.world, 50.0);
  EXPECT_EQ(guard->barrier_options.margin, 0.01);
  EXPECT_EQ(guard->barrier_options.residual_acceleration, 0.2);
  EXPECT_EQ(guard->position_sigma, 0.03);
  const SupervisorOptions& o = *guard->supervisor;
  EXPECT_EQ(o.times.fresh, 0.03);
  EXPECT_EQ(o.times.slow_after, 0.21);
  EXPECT_EQ(o.times.hold_after, 0.51);
  EXPECT_EQ(o.times.land_after, 2.1);
  EXPECT_EQ(o.sigmas.hold, 0.8);
  EXPECT_EQ(o.sigmas.land, 1.8);
  EXPECT_EQ(guard->search, (SearchOptions{4.0, 0.5, 0.4, 1.2, 7.0}));
  EXPECT_EQ(o.slow_factor, 0.4);
  EXPECT_EQ(o.land_speed, 0.2);
  EXPECT_EQ(o.ground, 0.1);
  EXPECT_EQ(o.brake_time, 0.5);
  EXPECT_EQ(o.limits.v_max, 6.0);
  EXPECT_EQ(o.limits.turn_max, 3.0);
  EXPECT_EQ(o.limits.frozen_after, 0.4);
  EXPECT_EQ(o.limits.accept_after, 5);
  EXPECT_EQ(o.limits.world, 50.0);
  EXPECT_EQ(o.limits.position_sigma, 0.03);
  EXPECT_EQ(o.limits.heading_sigma, 0.04);
  EXPECT_EQ(o.period, 0.01);
}

TEST(ReadSafety, HardDistancesAndTopSpeedsAreThoseOfTheBodiesWhereTheySayThem) {
  const Scenario scenario = with_bodies("[safety]\nbarrier = \"report\"\nd_hard = 0.7\n");
  const auto guard = guard_options(scenario);
  ASSERT_TRUE(guard);
  EXPECT_EQ(guard->barrier, BarrierMode::report);
  EXPECT_FALSE(guard->supervisor);
  EXPECT_EQ(guard->bodies.at(0).d_hard, 0.7);
  EXPECT_EQ(guard->bodies.at(2).d_hard, 0.7);
  EXPECT_EQ(guard->bodies.at(2).speed_max, 0.0) << "it rests";
  EXPECT_EQ(guard->bodies.at(3).d_hard, 1.2);
  EXPECT_EQ(guard->bodies.at(3).speed_max, 0.4);
  EXPECT_EQ(hard_distance(scenario, BodyId{0}, BodyId{1}), 0.7);
  EXPECT_EQ(hard_distance(scenario, BodyId{3}, BodyId{1}), 1.2);
  EXPECT_EQ(hard_distance(scenario, BodyId{2}, BodyId{3}), std::nullopt) << "nobody steers either";
  EXPECT_EQ(hard_distance(with_bodies(""), BodyId{0}, BodyId{1}), std::nullopt);
  EXPECT_EQ(hard_distance(with_bodies(""), BodyId{0}, BodyId{3}), 1.2);
}

TEST(ReadSafety, NoiseThatIsSimulatedIsReckonedWithUnlessItIsSaid) {
  const std::string noisy =
      "[simulation.disturbance]\nnoise = { position = 0.02, heading = 0.03 }\n[safety]\n";
  EXPECT_EQ(with_bodies(noisy).safety->position_sigma, 0.02);
  EXPECT_EQ(with_bodies(noisy).safety->heading_sigma, 0.03);
  EXPECT_EQ(with_bodies(noisy + "position_sigma = 0.0\n").safety->position_sigma, 0.0);
}

TEST(ReadSafety, FaultsReachTheSimulation) {
  const Scenario scenario = with_bodies(R"(
[[simulation.fault]]
kind = "dropout"
body = "b"
from = 1.0
until = 2.0
probability = 0.3
[[simulation.fault]]
kind = "delay"
delay = 0.25
[[simulation.fault]]
kind = "nan"
body = "a"
state = "v_s"
[[simulation.fault]]
kind = "jump"
body = "t"
offset = [1.0, 2.0, 3.0]
[[simulation.fault]]
kind = "freeze"
[[simulation.fault]]
kind = "late_plan"
from = 3.0
delay = 0.07
)");
  const auto& faults = scenario.simulation.faults;
  ASSERT_EQ(faults.size(), 5U);
  EXPECT_EQ(faults[0].kind, FaultKind::dropout);
  EXPECT_EQ(faults[0].body, BodyId{1});
  EXPECT_EQ(faults[0].from, 1.0);
  EXPECT_EQ(faults[0].until, 2.0);
  EXPECT_EQ(faults[0].probability, 0.3);
  EXPECT_EQ(faults[1].kind, FaultKind::delay);
  EXPECT_EQ(faults[1].body.index, -1) << "of all bodies";
  EXPECT_EQ(faults[1].delay, 0.25);
  EXPECT_EQ(faults[2].kind, FaultKind::nan);
  EXPECT_EQ(faults[2].number, 6);
  EXPECT_EQ(faults[3].kind, FaultKind::jump);
  EXPECT_EQ(faults[3].offset.z, 3.0);
  EXPECT_EQ(faults[4].kind, FaultKind::freeze);
  ASSERT_EQ(scenario.simulation.late_plans.size(), 1U);
  EXPECT_EQ(scenario.simulation.late_plans[0].from, 3.0);
  EXPECT_EQ(scenario.simulation.late_plans[0].delay, 0.07);
  EXPECT_EQ(sensor_options(scenario).faults.size(), 5U);
}

TEST(ReadSafety, TheBarrierTakesEachPresetOfARobotThatFliesOrSaysWhyNot) {
  const auto check = [](std::string_view robot) {
    std::string text = "[safety]\nbarrier = \"on\"\n";
    for (const char* name : {"a", "b"})
      text += fmt::format("[agent.{}]\nstart = {{ p = [{}, 0.0, 1.0] }}\n{}\n", name,
                          name[0] == 'a' ? 0.0 : 3.0, robot);
    return test::scenario_refusal(text);
  };
  for (const char* taken :
       {"robot = \"multirotor\"", "robot = \"angle_multirotor\"", "robot = \"omni_rover\"",
        "robot = \"hover_multirotor\"\nparameters = { preset = \"x500\" }",
        "robot = \"hover_multirotor\"\nparameters = { preset = \"crazyflie\" }",
        "robot = \"hover_multirotor\"\nparameters = { preset = \"ar_drone\" }",
        "robot = \"velocity_multirotor\"\nparameters = { preset = \"px4\" }",
        "robot = \"velocity_multirotor\"\nparameters = { preset = \"ar_drone\", frame = \"level\" }",
        "robot = \"velocity_multirotor\"\nparameters = { preset = \"ar_drone\", tau_psi = 0.0 }",
        "robot = \"velocity_multirotor\"\nparameters = { preset = \"ar_drone\", yaw_max = 0.5 }"})
    EXPECT_EQ(check(taken), "") << taken;
  EXPECT_THAT(check("robot = \"velocity_multirotor\"\nparameters = { preset = \"ar_drone\" }"),
              testing::HasSubstr(
                  "turns with its heading, faster than its commands accelerate it against that, expected a "
                  "lower yaw rate"));
}

TEST(ReadSafety, ARobotOfAnotherModelIsAssumedAsFastAsItsModelCanBe) {
  const std::string both = R"([agent.a]
robot = "multirotor"
start = { p = [-5.0, 0.0, 2.0], v = [2.0, 0.0] }
[agent.b]
robot = "angle_multirotor"
start = { p = [5.0, 0.0, 2.0] }
)";
  const auto assumed = [](const std::string& text) {
    std::vector<double> speeds;
    const auto options = guard_options(test::scenario_of(text));
    for (const BodySafety& body : options->bodies) speeds.push_back(body.speed_max);
    return speeds;
  };
  for (const double speed : assumed(both + "[safety]\nbarrier = \"on\"\n")) {
    EXPECT_GT(speed, 2.86);
    EXPECT_LT(speed, 6.0);
  }
  const std::vector<double> alike = assumed(std::string(bodies) + "[safety]\nbarrier = \"on\"\n");
  EXPECT_EQ(alike[0], BodySafety{}.speed_max) << "they cooperate";
}

constexpr const char* two_zones = R"(
[safety]
barrier = "on"
wall_margin = 0.1
[[safety.zone]]
polygon = [[-5, -5], [12, -5], [12, 5], [-5, 5]]
from = 0.2
keep = "inside"
[[safety.zone]]
polygon = [[1, 1], [1, 2], [2, 2]]
to = 2.5
keep = "outside"
)";

TEST(ReadSafety, ZonesReachTheBarrierAndTheSummary) {
  const Scenario scenario = with_bodies(two_zones);
  const auto guard = guard_options(scenario);
  ASSERT_TRUE(guard);
  const std::vector<Zone>& zones = guard->barrier_options.zones;
  ASSERT_EQ(zones.size(), 2U);
  EXPECT_EQ(zones[0].keep, Zone::Keep::inside);
  EXPECT_EQ(zones[0].polygon.size(), 4U);
  EXPECT_EQ(zones[0].polygon[1].x, 12.0);
  EXPECT_EQ(zones[0].polygon[1].y, -5.0);
  EXPECT_EQ(zones[0].from, 0.2);
  EXPECT_EQ(zones[0].to, infinity);
  EXPECT_EQ(zones[1].keep, Zone::Keep::outside);
  EXPECT_EQ(zones[1].from, -infinity);
  EXPECT_EQ(zones[1].to, 2.5);
  const std::string text = summary(scenario);
  EXPECT_THAT(text, testing::HasSubstr("zone        keep inside 4 corners, from 0.2 m\n"));
  EXPECT_THAT(text, testing::HasSubstr("zone        keep outside 3 corners, to 2.5 m\n"));
}

TEST(ReadSafety, AStartOnTheWrongSideOfAZoneNeedsTheKeyThatAllowsIt) {
  const std::string zone =
      "[[safety.zone]]\npolygon = [[2, -1], [4, -1], [4, 1], [2, 1]]\nkeep = \"outside\"\n";
  EXPECT_THAT(
      test::scenario_refusal(bodies + zone),
      testing::HasSubstr("agent.b.start.p = [3, 0, 1], expected a place outside safety.zone[0], 1 m"));
  EXPECT_TRUE(with_bodies("[safety]\nstart_outside = true\n" + zone).safety->start_outside);
  EXPECT_THAT(
      test::scenario_refusal(bodies + std::string("[safety]\nstart_outside = true\n") +
                             "[[safety.zone]]\npolygon = [[2, 2], [4, 2], [4, 3]]\nkeep = \"outside\"\n"),
      testing::HasSubstr("within the walls and zones that are judged"));
}

TEST(ReadSafety, AReferenceThatZonesLeaveNoPlaceForIsAWarning) {
  const auto warnings = [](const std::string& reference) {
    return check_scenario(test::scenario_of("[agent.a]\nrobot = \"multirotor\"\nQ = [1, 1, 1, 1, 1, 0, 0]\n"
                                            "start = { p = [0.0, 0.0, 1.0] }\n" +
                                            reference + std::string(two_zones)))
        .warnings;
  };
  const auto no_place = testing::HasSubstr("no place for the reference of a");
  EXPECT_THAT(warnings("reference = { constant = { p = [0.0, 0.0, 1.0] } }\n"),
              testing::Not(testing::Contains(no_place)));
  for (const char* p : {"[1.2, 1.7, 1.0]", "[2.05, 2.0, 1.0]", "[12.5, 0.0, 1.0]", "[0.0, 0.0, 0.25]"})
    EXPECT_THAT(warnings(fmt::format("reference = {{ constant = {{ p = {} }} }}\n", p)),
                testing::Contains(no_place))
        << p;
  EXPECT_THAT(warnings("reference = { constant = { p = [1.2, 1.7, 2.7] } }\n"),
              testing::Not(testing::Contains(no_place)));
}

TEST(ReadSafety, WhatIsSwitchedOnIsPrinted) {
  const std::string text = summary(with_bodies(R"(
[safety]
barrier = "on"
[safety.supervisor]
[[simulation.fault]]
kind = "freeze"
body = "a"
from = 1.0
[[simulation.fault]]
kind = "late_plan"
until = 2.0
delay = 0.1
)"));
  EXPECT_THAT(text, testing::HasSubstr("barrier on, d_hard 0.6 m, height 0.3 to 10 m, world 100 m\n"));
  EXPECT_THAT(text, testing::HasSubstr("slow after 0.2 s, hold after 0.5 s, land after 2 s\n"));
  EXPECT_THAT(text, testing::HasSubstr("freeze of a, from 1 s on\n"));
  EXPECT_THAT(text, testing::HasSubstr("plans 0.1 s late, from 0 to 2 s\n"));
}

}  // namespace
}  // namespace sightline
