#include "bridges/dds/first_flyer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bridges/dds/topics/channel.hpp"
#include "tests/dds/fly.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scenario_text.hpp"

extern "C" {
#include "px4.h"
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

TEST(FirstFlyer, AVehicleThatIsCommandedAlreadyIsRefusedByName) {
  const Scenario scenario = test::scenario_of(fmt::format(
      "[fleet]\ndomain = {}\n"
      "[agent.a]\nrobot = \"multirotor\"\nstart = {{ p = [0, 0, 1] }}\n[agent.a.link]\nkind = \"px4\"\n"
      "release = \"1.16\"\nnamespace = \"/px4_1\"\norigin = {{ p = [0, 0, 0] }}\n"
      "[agent.b]\nrobot = \"unicycle\"\nstart = {{ p = [3, 0, 0] }}\n[agent.b.link]\nkind = \"ros2\"\n"
      "odometry = \"/b/odom\"\ncmd_vel = \"/b/cmd_vel\"\n"
      "[agent.c]\nrobot = \"multirotor\"\nstart = {{ p = [6, 0, 1] }}\n[agent.c.link]\nkind = "
      "\"crazyswarm2\"\n",
      test::own_domain()));
  const Domain domain(test::own_network());
  const auto refusal = [&] {
    return refusal_of<std::runtime_error>([&] { refuse_second_flyer(scenario, domain); });
  };
  const dds_entity_t other = domain.another_participant();
  // What robots themselves write, and what others write to other robots.
  const RawWriter odometry(other, px4_msgs_msg_dds__VehicleOdometry__desc, "/px4_1/fmu/out/vehicle_odometry",
                           of_sensors);
  const RawWriter second(other, px4_msgs_msg_dds__TrajectorySetpoint__desc,
                         "/px4_2/fmu/in/trajectory_setpoint", of_sensors);
  const RawWriter longer(other, geometry_msgs_msg_dds__Twist__desc, "/b/cmd_vel_nav", of_ros_commands);
  EXPECT_EQ(refusal(), "");
  struct Row {
    const dds_topic_descriptor_t* type;
    std::string topic, robot;
  };
  for (const auto& [type, topic, robot] :
       {Row{&px4_msgs_msg_dds__TrajectorySetpoint__desc, "/px4_1/fmu/in/trajectory_setpoint", "agent.a"},
        Row{&px4_msgs_msg_dds__TrajectorySetpoint__desc, "/px4_1/fmu/in/trajectory_setpoint_v1", "agent.a"},
        Row{&geometry_msgs_msg_dds__Twist__desc, "/b/cmd_vel", "agent.b"},
        Row{&geometry_msgs_msg_dds__Twist__desc, "/c/cmd_vel_legacy", "agent.c"}}) {
    const RawWriter rival(other, *type, topic, of_ros_commands);
    EXPECT_THAT(refusal(), HasSubstr(robot + ": another program writes rt" + topic + " already"));
  }
}

using TwoFlyers = FlyTest;

TEST_F(TwoFlyers, TheSecondIsRefusedAndTheFirstFliesOn) {
  const auto fleet = desk("60.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto first = begin(flight(fleet, "first"), "first");
  ASSERT_TRUE(prints("first.err", "the task begins")) << printed("first.err") << printed("vehicles.err");
  const auto begun = std::chrono::steady_clock::now();
  const auto second = begin(flight(fleet, "second"), "second");
  EXPECT_TRUE(test::eventually([&] { return second->ended(); }, std::chrono::seconds(10)));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(10));
  EXPECT_EQ(second->code(), 2);
  EXPECT_THAT(printed("second.err"), HasSubstr("already, expected one flyer for each robot"));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_FALSE(first->ended());
  EXPECT_THAT(printed("first.err"), Not(HasSubstr("landing")));
  ::kill(first->pid(), SIGINT);
  EXPECT_TRUE(test::eventually([&] { return first->ended(); }, std::chrono::seconds(20)));
  EXPECT_EQ(first->code(), 0) << printed("first.err");
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr(" 1 requests to arm, 1 for offboard, disarmed"));
}

// Both may be refused; no vehicle is asked to arm by two.
TEST_F(TwoFlyers, WhoBeginAtTheSameTimeDoNotBothFly) {
  const auto fleet = desk("1.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto one = begin(flight(fleet, "one"), "one"), two = begin(flight(fleet, "two"), "two");
  EXPECT_TRUE(test::eventually([&] { return one->ended() && two->ended(); }, std::chrono::seconds(40)));
  EXPECT_FALSE(one->code() == 0 && two->code() == 0) << printed("one.err") << printed("two.err");
  for (const auto& [flyer, name] : {std::pair(one.get(), "one.err"), std::pair(two.get(), "two.err")}) {
    if (flyer->code() == 0) continue;
    EXPECT_THAT(printed(name), AnyOf(HasSubstr("another program writes"), HasSubstr("second")));
  }
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), Not(testing::ContainsRegex(" [2-9] requests to arm")));
}

}  // namespace
}  // namespace sightline::dds
