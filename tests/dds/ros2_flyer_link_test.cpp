#include "bridges/dds/links/ros2_flyer_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bridges/dds/simulators/ros2_flyer.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::IsEmpty;

/// What one of them is: its robot, and what its link says besides the topics.
struct FlyerKind {
  std::string robot, link;
};
const FlyerKind by_topics = {"velocity_multirotor", ""},
                ar_drone = {"multirotor", "commands = \"normalised\"\nstamped = true\n"},
                by_services = {"velocity_multirotor", "calls = \"empty\"\nstate = \"/by_services/state\"\n"},
                by_trigger = {"velocity_multirotor", "calls = \"trigger\"\nframe = \"odom\"\n"};

/// In a row, 3 m apart, whose odometries begin elsewhere and turned.
Scenario flyers(const std::vector<FlyerKind>& kinds, double duration) {
  std::string text = fmt::format(
      "[fleet]\ndomain = {}\n[simulation]\nduration = {}\n[safety]\nbarrier = \"off\"\nfloor = 0.1\n"
      "position_sigma = 0.01\nheading_sigma = 0.01\n[safety.supervisor]\nfresh = 0.05\n",
      test::own_domain(), duration);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const bool tilts = kinds[i].robot == "multirotor";
    text += fmt::format(
        "[agent.uav{0}]\nrobot = \"{1}\"\nstart = {{ p = [{2}, 0.0, 0.8], heading = 0.7 }}\nQ = [1.5, 1.5, "
        "1.6, 0, "
        "0, {3}]\nreference = {{ circle = {{ centre = [{2}, 0.0, 0.9], radius = 0.3, rate = 0.5 }} }}\n"
        "{5}[agent.uav{0}.link]\nkind = \"ros2\"\nodometry = \"/uav{0}/odom\"\ncmd_vel = "
        "\"/uav{0}/cmd_vel\"\ntakeoff = "
        "\"/uav{0}/takeoff\"\nland = \"/uav{0}/land\"\norigin = {{ p = [{2}, 0.2, 0.1], heading = -0.6 "
        "}}\n{4}",
        i, kinds[i].robot, 3 * i, tilts ? "0, 0" : "0, 0, 0, 0", kinds[i].link,
        tilts ? ""
              : fmt::format(
                    "[agent.uav{}.parameters]\ntau_f = 0.3\ntau_s = 0.3\ntau_z = 0.3\ntau_psi = 0.1\n", i));
  }
  return test::scenario_of(text);
}

Ros2Flyer& flyer_of(Rig& rig, std::size_t i) { return rig.as<Ros2Flyer>(i); }

TEST(Ros2FlyerLink, EachKindTakesOffFliesItsTaskAndLands) {
  Rig rig(flyers({by_topics, ar_drone, by_services, by_trigger}, 2.0));
  const LoopOutcome outcome = rig.fly();
  EXPECT_TRUE(outcome.finite) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 4; ++i) {
    const Ros2FlyerCounts n = flyer_of(rig, i).reported();
    EXPECT_EQ(n.takeoffs, 1) << i;
    EXPECT_EQ(n.landings, 1) << i;
    EXPECT_EQ(n.commands_outside, 0) << i;
    EXPECT_EQ(n.bad, 0) << i;
    EXPECT_GT(n.commands, 150) << i;
    EXPECT_EQ(flyer_of(rig, i).state(), Ros2State::landed) << i;
    const Motion m = flyer_of(rig, i).motion();  // where its circle ended, or near by
    EXPECT_NEAR(norm(m.p.x - 3.0 * static_cast<double>(i), m.p.y), 0.3, 0.25) << i;
  }
}

TEST(Ros2FlyerLink, WhatItIsRefusedItDoesNotAskAgain) {
  Rig rig(flyers({by_trigger, by_topics}, 5.0));
  flyer_of(rig, 0).refuse_requests(true);
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.world->faults(), Contains("uav0: it refused the request"));
  EXPECT_EQ(flyer_of(rig, 0).reported().takeoffs, 1);
  EXPECT_EQ(flyer_of(rig, 0).reported().commands_outside, 0);
  EXPECT_TRUE(test::eventually([&] { return flyer_of(rig, 1).state() == Ros2State::landed; }));
}

TEST(Ros2FlyerLink, OneThatSomebodyElseLandsIsLeftToThem) {
  Rig rig(flyers({by_services, by_topics}, 20.0));
  const LoopOutcome outcome = rig.fly(0.5, [&] { flyer_of(rig, 0).land_by_itself(); });
  EXPECT_FALSE(outcome.finite);
  EXPECT_EQ(rig.state(0), LinkState::pilot);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_THAT(rig.world->faults(), Contains("uav0: a pilot has it"));
  EXPECT_EQ(flyer_of(rig, 0).reported().landings, 0);
  EXPECT_EQ(flyer_of(rig, 1).state(), Ros2State::landed);
}

TEST(Ros2FlyerLink, WhereItFallsSilentItIsAskedToLand) {
  Rig rig(flyers({by_topics}, 20.0), {.landing = 2.5});
  const LoopOutcome outcome = rig.fly(0.5, [&] { rig.faults(0).begin(Kind::silent); });
  EXPECT_FALSE(outcome.finite);
  EXPECT_THAT(rig.world->faults(), Contains("uav0: nothing came from it any more"));
  EXPECT_GE(flyer_of(rig, 0).reported().landings, 1);
  EXPECT_EQ(flyer_of(rig, 0).state(), Ros2State::landed);
}

TEST(Ros2FlyerLink, WithoutADriverItSaysWhatIsMissing) {
  const Scenario scenario = flyers({by_services}, 1.0);
  const Fields reported = not_ready(scenario, std::make_shared<Domain>(fleet_of(scenario).network), 0.5);
  for (const char* sentence :
       {"uav0: rt/uav0/odom: no message, it has no publisher", "uav0: rt/uav0/cmd_vel: it has no subscriber",
        "uav0: /uav0/takeoff: no server", "uav0: rt/by_services/state: no message, it has no publisher"})
    EXPECT_THAT(reported, Contains(sentence));
}

}  // namespace
}  // namespace sightline::dds
