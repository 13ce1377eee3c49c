#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bridges/dds/fleet/link.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::scenario_of;
using test::scenario_refusal;
using testing::HasSubstr;

const std::string fleet_of_two =
    "[fleet]\n[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.a.link]\nkind = \"px4\"\n"
    "release = \"1.16\"\norigin = { p = [0, 0, 0], heading = 0 }\n"
    "[agent.b]\nrobot = \"unicycle\"\nstart = { p = [3, 0, 0] }\n[agent.b.link]\nkind = \"ros2\"\n"
    "odometry = \"/odom\"\ncmd_vel = \"/cmd_vel\"\n";

std::string with_fault(const std::string& text) { return fleet_of_two + "[[fleet.fault]]\n" + text; }

TEST(ReadLinkFault, EachHasWhatTheFileSaysAndTheUsualSize) {
  const Scenario s = scenario_of(with_fault(
      "robot = \"a\"\nkind = \"jump_told\"\nsince = \"flight\"\nat = 5.0\nduration = 2.0\nsize = -0.3\n"
      "[[fleet.fault]]\nrobot = \"b\"\nkind = \"drop\"\nat = 1\n"));
  ASSERT_EQ(fleet_of(s).faults.size(), 2u);
  const LinkFault& jump = fleet_of(s).faults[0];
  EXPECT_EQ(jump.kind, LinkFaultKind::jump_reported);
  EXPECT_EQ(jump.since, FaultClock::flight);
  EXPECT_EQ(jump.at, 5.0);
  EXPECT_EQ(jump.duration, 2.0);
  EXPECT_EQ(jump.size, -0.3);
  const LinkFault& drop = fleet_of(s).faults[1];
  EXPECT_EQ(s.team.name(drop.robot), "b");
  EXPECT_EQ(drop.since, FaultClock::start);
  EXPECT_EQ(drop.size, 0.2);
  EXPECT_FALSE(std::isfinite(drop.duration));
  EXPECT_THAT(summary(s), HasSubstr("fault       b: drop 0.2, 1 s after the start\n"));
}

TEST(ReadLinkFault, WhatDoesNotHoldIsRefusedWithItsPlace) {
  struct Case {
    std::string text, said;
  };
  const std::vector<Case> cases = {
      {"kind = \"drop\"\nat = 1\n", "robot is missing, expected"},
      {"robot = \"c\"\nkind = \"drop\"\nat = 1\n", "robot = \"c\", expected the robot that has it"},
      {"robot = \"a\"\nkind = \"dorp\"\nat = 1\n", "kind = \"dorp\", expected one of \"drop\", \"delay\""},
      {"robot = \"b\"\nkind = \"pilot\"\nat = 1\n",
       "kind = \"pilot\", expected a fault of robots behind ros2, pilot is not"},
      {"robot = \"a\"\nkind = \"drop\"\n", "at is missing, expected"},
      {"robot = \"a\"\nkind = \"drop\"\nat = -1\n", "at = -1, expected 0 to 1e6 s"},
      {"robot = \"a\"\nkind = \"drop\"\nat = 1\nsize = 1.5\n", "size = 1.5, expected 0 to 1 share"},
      {"robot = \"a\"\nkind = \"silent\"\nat = 1\nsize = 1\n", "size = 1, expected no such key for silent"},
      {"robot = \"a\"\nkind = \"drop\"\nat = 1\nduration = 0\n", "duration = 0, expected 0.001 to 1e6 s"},
      {"robot = \"a\"\nkind = \"drop\"\nat = 1\nsince = \"task\"\n",
       "since = \"task\", expected one of \"start\", \"flight\""},
      {"robot = \"a\"\nkind = \"wrong_release\"\nat = 1\nsize = 13\n", "size = 13, expected 14 to 18 1.N"},
      {"robot = \"a\"\nkind = \"drop\"\nat = 1\nfor = 2\n", "for = 2, expected"},
  };
  for (const Case& c : cases) EXPECT_THAT(scenario_refusal(with_fault(c.text)), HasSubstr(c.said)) << c.text;
}

}  // namespace
}  // namespace sightline
