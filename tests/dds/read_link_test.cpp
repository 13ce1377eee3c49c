#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "bridges/dds/fleet/link.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::scenario_of;
using test::scenario_refusal;
using testing::EndsWith;
using testing::HasSubstr;

const std::string agent = "[agent.uav0]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n";

std::string fleet(const std::string& link, const std::string& network = "") {
  return "[fleet]\n" + network + agent + "[agent.uav0.link]\n" + link;
}
const std::string px4 = "kind = \"px4\"\nrelease = \"1.16\"\norigin = { p = [1, 2, 3], heading = 0.5 }\n";

TEST(ReadLink, EachKindHasWhatTheFileSaysAndDefaultsForTheRest) {
  const Scenario a = scenario_of(fleet(px4 + "namespace = \"/px4_1\"\ntarget_system = 2\n"));
  ASSERT_EQ(fleet_of(a).links.size(), 1u);
  const Link& link = fleet_of(a).links[0];
  const auto& vehicle = std::get<Px4Link>(link.kind);
  EXPECT_EQ(vehicle.release, Px4Release::v1_16);
  EXPECT_EQ(vehicle.name_space, "/px4_1");
  EXPECT_EQ(vehicle.target_system, 2);
  EXPECT_EQ(link.origin.p.z, 3.0);
  EXPECT_EQ(link.origin.heading, 0.5);
  EXPECT_EQ(link.poses.source, PoseSource::odometry);
  EXPECT_THAT(summary(a),
              HasSubstr("link        uav0: /px4_1 of PX4 1.16, poses by odometry, origin [1, 2, 3] m\n"));

  const Scenario b = scenario_of(
      fleet("kind = \"crazyswarm2\"\nposes = \"mocap\"\npose_topic = \"/poses\"\npose_name = \"cf1\"\n"));
  const auto& crazyflie = std::get<Crazyswarm2Link>(fleet_of(b).links[0].kind);
  EXPECT_EQ(crazyflie.name_space, "/uav0");
  EXPECT_EQ(fleet_of(b).links[0].poses.source, PoseSource::mocap);
  EXPECT_EQ(fleet_of(b).links[0].poses.name, "cf1");
  EXPECT_EQ(fleet_of(b).links[0].poses.frame, "world");

  const Scenario c =
      scenario_of(fleet("kind = \"ros2\"\nodometry = \"/r/odom\"\ncmd_vel = \"/r/cmd_vel\"\nstamped = "
                        "true\nframe = \"odom\"\n"));
  const auto& rover = std::get<Ros2Link>(fleet_of(c).links[0].kind);
  EXPECT_EQ(rover.odometry, "/r/odom");
  EXPECT_TRUE(rover.stamped);
  EXPECT_EQ(rover.frame, "odom");

  const Scenario d =
      scenario_of(fleet("kind = \"ros2\"\ncmd_vel = \"/r/cmd_vel\"\nposes = \"tf\"\npose_name = "
                        "\"base_link\"\npose_frame = \"map\"\n"));
  EXPECT_EQ(fleet_of(d).links[0].poses.source, PoseSource::tf);
  EXPECT_EQ(fleet_of(d).links[0].poses.frame, "map");
  EXPECT_THAT(summary(d),
              HasSubstr("link        uav0: /r/cmd_vel, poses by tf of base_link, origin [0, 0, 0] m\n"));
}

const std::string linked_by_view =
    "[fleet]\n[agent.uav0]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\nlocalization = "
    "\"vision\"\nobserves "
    "= [\"uav1\"]\nsensor = {}\ncamera = {}\n[agent.uav1]\nrobot = \"multirotor\"\nstart = { p = [2, 0, 1] "
    "}\ntags "
    "= {}\n[agent.uav1.link]\n" +
    px4 + "[agent.uav0.link]\nkind = \"px4\"\nrelease = \"1.16\"\nnamespace = \"/px4_1\"\n";

TEST(ReadLink, ARobotThatIsLocalizedByViewHasItsPosesByEstimate) {
  for (const std::string poses : {"", "poses = \"estimate\"\n"}) {
    const Scenario a = scenario_of(linked_by_view + poses);
    EXPECT_TRUE(fleet_of(a).links[0].poses.estimated());
    EXPECT_TRUE(fleet_of(a).links[0].has_camera);
    EXPECT_FALSE(fleet_of(a).links[1].poses.estimated());
    EXPECT_THAT(summary(a), HasSubstr("poses by estimate, motion by odometry\n"));
  }
  EXPECT_THAT(scenario_refusal(linked_by_view + "poses = \"odometry\"\n"),
              HasSubstr("agent.uav0.link.poses = \"odometry\", expected \"estimate\""));
  EXPECT_THAT(scenario_refusal(linked_by_view + "origin = { p = [0, 0, 0], heading = 0 }\n"),
              HasSubstr("expected no such key with poses = \"estimate\""));
  EXPECT_THAT(scenario_refusal(linked_by_view + "pose_name = \"a\"\n"),
              HasSubstr("agent.uav0.link.pose_name"));
}

TEST(ReadLink, ARobotThatTakesGoalsHasAReferenceThatTheyChange) {
  const std::string weighs =
      "[agent.uav0]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\nQ = [1, 1, 1, 0, 0, 0, 0]\n"
      "reference = { constant = { p = [0, 0, 2] } }\n";
  const Scenario a = scenario_of("[fleet]\n" + weighs + "[agent.uav0.link]\n" + px4 +
                                 "goal_topic = \"/uav0/goal\"\ngoal_speed = 1.5\ngoal_frame = \"map\"\n");
  const GoalsFrom& goals = fleet_of(a).links[0].goals;
  EXPECT_EQ(goals.goal_topic, "/uav0/goal");
  EXPECT_EQ(goals.path_topic, "");
  EXPECT_EQ(goals.frame, "map");
  EXPECT_EQ(goals.speed, 1.5);
  ASSERT_EQ(a.goals.size(), 1u);
  EXPECT_EQ(a.goals[0].robot, fleet_of(a).links[0].robot);
  std::vector<double> x(7);
  const auto height = [&](double t) {
    a.team.agents()[0].x_ref(t, a.team.agents()[0].model, x);
    return x[2];
  };
  EXPECT_EQ(height(1.0), 2.0);
  EXPECT_EQ(a.goals[0].track->add(1.0, std::vector{Waypoint{.p = {0, 0, 3}}}), GoalAnswer::taken);
  EXPECT_EQ(height(9.0), 3.0);
  EXPECT_THAT(summary(a), HasSubstr("origin [1, 2, 3] m, goals on /uav0/goal\n"));
}

TEST(ReadLink, TargetsAndObstaclesMayBeSeenByOthers) {
  const Scenario a = scenario_of(
      fleet(px4) +
      "[target.lamp]\np = [1, 0, 1]\n[target.lamp.link]\nposes = \"mocap\"\npose_topic = \"/lamp/pose\"\n"
      "[obstacle.box]\np = [3, 0, 1]\n"
      "[obstacle.cart]\np = [5, 0, 0]\nlink = { poses = \"tf\", pose_name = \"cart\", pose_frame = \"map\" "
      "}\n");
  ASSERT_EQ(fleet_of(a).bodies.size(), 2u);
  EXPECT_EQ(a.team.name(fleet_of(a).bodies[0].body), "lamp");
  EXPECT_EQ(fleet_of(a).bodies[0].poses.topic, "/lamp/pose");
  EXPECT_EQ(fleet_of(a).bodies[1].poses.frame, "map");
  EXPECT_THAT(summary(a), HasSubstr("link        cart: poses by tf of cart\n"));
  // What others see may move, whatever it does in simulation.
  EXPECT_EQ(a.uncooperative[0].speed_max, 1.5);
  EXPECT_EQ(a.uncooperative[1].speed_max, 0.0);
}

TEST(ReadLink, WhatFliesOnRos2SaysWhatTakesItOffAndLandsIt) {
  const std::string ros2 = "kind = \"ros2\"\nodometry = \"/o\"\ncmd_vel = \"/c\"\n";
  EXPECT_FALSE(std::get<Ros2Link>(fleet_of(scenario_of(fleet(ros2))).links[0].kind).flies());
  const Scenario a = scenario_of(fleet(
      ros2 +
      "takeoff = \"/t\"\nland = \"/l\"\nstate = \"/s\"\ncalls = \"trigger\"\ncommands = \"normalised\"\n"));
  const auto& link = std::get<Ros2Link>(fleet_of(a).links[0].kind);
  EXPECT_TRUE(link.flies());
  EXPECT_EQ(link.land, "/l");
  EXPECT_EQ(link.state, "/s");
  EXPECT_EQ(link.calls, FlightCalls::trigger);
  EXPECT_EQ(link.commands, FlightCommands::normalised);
  EXPECT_THAT(scenario_refusal(fleet(ros2 + "takeoff = \"/t\"\n")),
              HasSubstr("link.land is missing, expected what lands it, a topic or a service"));
  EXPECT_THAT(scenario_refusal(fleet(ros2 + "state = \"/s\"\n")),
              EndsWith("link.state = \"/s\", expected no such key, only with takeoff and land"));
  EXPECT_THAT(scenario_refusal(fleet(ros2 + "takeoff = \"/t\"\nland = \"/l\"\ncalls = \"actions\"\n")),
              HasSubstr("expected one of \"topics\", \"empty\", \"trigger\""));
  EXPECT_THAT(scenario_refusal(fleet("kind = \"crazyswarm2\"\nbattery_min = 0\n")),
              EndsWith("expected 2.5 to 30 V"));
}

TEST(ReadLink, TheLogOfACrazyfliesImuHasEachVariableOnce) {
  const std::string kind = "kind = \"crazyswarm2\"\norigin = { p = [0, 0, 0], heading = 0.0 }\n";
  const auto read = [&](const std::string& keys) {
    return std::get<Crazyswarm2Link>(fleet_of(scenario_of(fleet(kind + keys))).links[0].kind);
  };
  EXPECT_EQ(read("").imu, "");
  EXPECT_EQ(read("imu = \"/cf1/imu\"\n").imu_vars.size(), crazyflie_imu.size());
  const std::string six = "\"acc.z\", \"acc.y\", \"acc.x\", \"gyro.x\", \"gyro.y\", \"gyro.z\"";
  EXPECT_EQ(read("imu = \"/cf1/imu\"\nimu_vars = [" + six + ", \"pm.state\"]\n").imu_vars.back(), "pm.state");
  EXPECT_THAT(scenario_refusal(fleet(kind + "imu_vars = [" + six + "]\n")),
              HasSubstr("expected no such key, only with imu"));
  for (const char* more : {", \"acc.z\"", ", \"a.a\", \"a.b\", \"a.c\""})
    EXPECT_THAT(scenario_refusal(fleet(kind + "imu = \"/cf1/imu\"\nimu_vars = [" + six + more + "]\n")),
                HasSubstr("expected at most 8 variables of the log, each of gyro.x, gyro.y, gyro.z, acc.x, "
                          "acc.y, acc.z once"));
}

TEST(ReadLink, ANetworkIsLoopbackUnlessItIsGiven) {
  const Scenario a = scenario_of(fleet(px4));
  EXPECT_EQ(fleet_of(a).network.interfaces, std::vector<std::string>{"lo"});
  EXPECT_THAT(
      summary(a),
      HasSubstr("fleet       domain 0 on lo, asks 127.0.0.1, no multicast; /sightline shows the flight\n"));
  EXPECT_TRUE(fleet_of(a).network.topics);
  const Scenario b = scenario_of(fleet(
      px4,
      "domain = 5\ninterfaces = [\"eth0\"]\ndiscovery = { peers = [\"10.0.0.2\"], participants = 9 }\n"));
  EXPECT_EQ(fleet_of(b).network.domain, 5);
  EXPECT_EQ(fleet_of(b).network.peers, std::vector<std::string>{"10.0.0.2"});
  EXPECT_EQ(fleet_of(b).network.participants, 9);
  const Scenario quiet = scenario_of(fleet(px4, "node = \"/lab/flyer_2\"\ntopics = false\n"));
  EXPECT_THAT(summary(quiet), HasSubstr("no multicast; /lab/flyer_2 shows nothing\n"));
  EXPECT_EQ(fleet_of(scenario_of(fleet(px4, "interfaces = [\"eth0\"]\ndiscovery = { multicast = true }\n")))
                .network.multicast,
            Multicast::on);
}

// Which files they are follows from their names: what is in them, the bridge reads.
TEST(ReadLink, KeysAreInTheFoldersOfThoseWhoHaveThem) {
  const std::filesystem::path keys = test::fresh_folder() / "keys";
  const auto with = [&](const std::string& folder) {
    return fleet(px4, "security = { folder = \"" + folder + "\" }\n");
  };
  const auto refusal = [&] { return scenario_refusal(with(keys.string())); };
  EXPECT_THAT(refusal(),
              HasSubstr("expected a folder with flyer/ or vehicles/ in it, as scripts/dds_keys.sh makes it"));
  std::filesystem::create_directories(keys / "flyer");
  for (const std::string_view file : key_files) {
    EXPECT_THAT(refusal(), EndsWith(fmt::format("expected flyer/{} in it, which is missing", file)));
    std::ofstream(keys / "flyer" / file) << "here";
  }
  const Scenario scenario = scenario_of(with(keys.string()));
  EXPECT_EQ(fleet_of(scenario).network.keys, keys);
  EXPECT_THAT(summary(scenario), HasSubstr("no multicast, DDS security; "));
  std::filesystem::create_directories(keys / "vehicles");
  EXPECT_THAT(refusal(), HasSubstr("expected vehicles/identity_ca.cert.pem in it"));
  for (const std::string folder : {"", "a\\nb", "${HOME}"})
    EXPECT_THAT(scenario_refusal(with(folder)), HasSubstr("expected a folder with flyer/")) << folder;
  EXPECT_THAT(scenario_refusal(fleet(px4, "security = { folder = \"a\", flyer = 1 }\n")),
              HasSubstr("expected a known key"));
}

TEST(ReadLink, WithoutAFleetAScenarioIsWhatItWas) {
  EXPECT_FALSE(scenario_of(agent).links);
  EXPECT_THAT(scenario_refusal(agent + "[agent.uav0.link]\n" + px4),
              EndsWith("expected no such table without a [fleet]"));
}

// Two robots would obey one stream of commands.
TEST(ReadLink, TwoRobotsWithTheTopicsOfOneAreRefused) {
  const auto another = [](const std::string& link) {
    return "[agent.uav1]\nrobot = \"multirotor\"\nstart = { p = [3, 0, 1] }\n[agent.uav1.link]\n" + link;
  };
  const std::string one = px4 + "namespace = \"/px4_1\"\n";
  EXPECT_EQ(fleet_of(scenario_of(fleet(one) + another(px4))).links.size(), 2U);
  EXPECT_THAT(
      scenario_refusal(fleet(one) + another(one)),
      HasSubstr(
          "agent.uav1.link.namespace = \"/px4_1\", expected topics of its own: another robot has these"));
  EXPECT_THAT(scenario_refusal(fleet(px4) + another(px4)),
              HasSubstr("agent.uav1.link.namespace is missing, expected"));
}

TEST(ReadLink, WhatDoesNotHoldIsRefusedWithItsPlace) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[fleet]\n" + agent, "agent.uav0.link is missing, expected a table with the link of the robot"},
      {fleet("kind = \"px5\"\n"), "a.toml:6: agent.uav0.link.kind = \"px5\", expected one of \"px4\""},
      {fleet("kind = \"px4\"\norigin = { p = [0, 0, 0] }\n"), "uav0.link.release is missing"},
      {fleet("kind = \"px4\"\nrelease = \"1.16\"\n"), "agent.uav0.link.origin is missing"},
      {fleet(px4 + "target_system = 0\n"), "link.target_system = 0, expected"},
      {fleet(px4 + "namespace = \"px4_1\"\n"), "link.namespace = \"px4_1\", expected the namespace"},
      {fleet(px4 + "odometry = \"/a\"\n"), "link.odometry = \"/a\", expected a known key"},
      {fleet(px4 + "poses = \"estimate\"\n"),
       "link.poses = \"estimate\", expected \"odometry\", \"mocap\" or \"tf\", or localization = \"vision\""},
      {fleet(px4 + "poses = \"mocap\"\n"), "link.pose_topic is missing, expected the topic of its poses"},
      {fleet(px4 + "poses = \"tf\"\n"), "link.pose_name is missing, expected what motion capture"},
      {fleet(px4 + "goal_topic = \"/g\"\n"), "link.goal_topic = \"/g\", expected a robot whose Q weighs"},
      {fleet(px4 + "goal_speed = 1\n"), "link.goal_speed = 1, expected no such key"},
      {fleet(px4 + "poses = \"tf\"\npose_name = \"world\"\n"),
       "link.pose_name = \"world\", expected another frame than pose_frame, \"world\""},
      {fleet(px4 + "pose_frame = \"map\"\n"), "link.pose_frame = \"map\", expected no such key"},
      {fleet("kind = \"ros2\"\ncmd_vel = \"/v\"\nodometry = \"/o\"\nposes = \"tf\"\npose_name = \"b\"\n"),
       "link.odometry = \"/o\", expected no such key, only with poses = \"odometry\""},
      {fleet("kind = \"crazyswarm2\"\nposes = \"tf\"\npose_name = \"b\"\norigin = { p = [0, 0, 0] }\n"),
       "expected no such key, only with poses = \"odometry\": those of others are in G"},
      {fleet(px4) + "[target.lamp]\np = [0, 0, 1]\nlink = { poses = \"odometry\" }\n",
       "target.lamp.link.poses = \"odometry\", expected \"mocap\" or \"tf\": where others see it"},
      {agent + "[target.lamp]\np = [0, 0, 1]\nlink = { poses = \"tf\", pose_name = \"b\" }\n",
       "target.lamp.link = {...}, expected no such table without a [fleet]"},
      {fleet(px4, "domain = 231\n"), "fleet.domain = 231, expected an integer, 0 to 230"},
      {fleet(px4, "interfaces = [\"eth0\"]\n"), "fleet.discovery.peers is missing, expected the addresses"},
      {fleet(px4, "interfaces = [\"<x/>\"]\n"), "fleet.interfaces[0] = \"<x/>\", expected names"},
      {fleet(px4, "interfaces = []\n"), "fleet.interfaces = [], expected an array of one or more"},
      {fleet(px4, "discovery = { peer = [\"a\"] }\n"), "expected a known key, the nearest is \"peers\""}};
  for (const auto& [text, sentence] : cases) EXPECT_THAT(scenario_refusal(text), HasSubstr(sentence)) << text;
}

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
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"kind = \"drop\"\nat = 1\n", "robot is missing, expected"},
      {"robot = \"c\"\nkind = \"drop\"\nat = 1\n", "robot = \"c\", expected the robot that has it"},
      {"robot = \"a\"\nkind = \"dorp\"\nat = 1\n", "kind = \"dorp\", expected one of \"drop\", \"delay\""},
      {"robot = \"b\"\nkind = \"pilot\"\nat = 1\n",
       "kind = \"pilot\", expected a fault of robots behind ros2"},
      {"robot = \"a\"\nkind = \"drop\"\nat = 1\nsize = 1.5\n", "size = 1.5, expected 0 to 1 share"},
      {"robot = \"a\"\nkind = \"silent\"\nat = 1\nsize = 1\n", "size = 1, expected no such key for silent"},
      {"robot = \"a\"\nkind = \"drop\"\nat = 1\nduration = 0\n", "duration = 0, expected 0.001 to 1e6 s"},
      {"robot = \"a\"\nkind = \"wrong_release\"\nat = 1\nsize = 13\n", "size = 13, expected 14 to 18 1.N"},
      {"robot = \"a\"\nkind = \"drop\"\nat = 1\nfor = 2\n", "for = 2, expected"},
  };
  for (const auto& [text, sentence] : cases)
    EXPECT_THAT(scenario_refusal(with_fault(text)), HasSubstr(sentence)) << text;
}

}  // namespace
}  // namespace sightline
