#include "bridges/dds/topics/goal_subscriber.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model.hpp"
#include "tests/dds/fly.hpp"
#include "tests/dds/rig.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// One who sends goals and paths.
class Operator {
 public:
  Operator(const Domain& domain, const std::string& robot)
      : goal_(domain.participant(), geometry_msgs_msg_dds__PoseStamped__desc, "/" + robot + "/goal",
              {.reliable = true}),
        path_(domain.participant(), nav_msgs_msg_dds__Path__desc, "/" + robot + "/path", {.reliable = true}) {
  }

  bool is_received() const { return goal_.matched() > 0 && path_.matched() > 0; }
  void goal(const Vec3<double>& p, double heading = 0.0, std::string frame = "world", double w_too = 0.0) {
    const geometry_msgs_msg_dds__PoseStamped_ m = {{{}, frame.data()}, pose(p, heading, w_too)};
    (void)goal_.write(&m);
  }
  /// @param after  the stamps of the poses after that of the header [s]
  void path(const std::vector<double>& after, const std::vector<Vec3<double>>& p) {
    std::string frame = "world", none;
    std::vector<geometry_msgs_msg_dds__PoseStamped_> poses;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const RosTime stamp = to_ros(1'000'000'000'000 + std::llround(1e9 * after[i]));
      poses.push_back(
          {{{stamp.sec, stamp.nanosec}, i % 2 == 0 ? frame.data() : none.data()}, pose(p[i], 0.0, 0.0)});
    }
    nav_msgs_msg_dds__Path_ m{};
    m.header = {{1000, 0}, frame.data()};
    m.poses._length = m.poses._maximum = static_cast<std::uint32_t>(poses.size());
    m.poses._buffer = poses.data();
    (void)path_.write(&m);
  }

 private:
  static geometry_msgs_msg_dds__Pose_ pose(const Vec3<double>& p, double heading, double w_too) {
    return {{p.x, p.y, p.z}, {0, 0, std::sin(heading / 2), std::cos(heading / 2) + w_too}};
  }
  RawWriter goal_, path_;
};

const GoalsFrom goals_of_uav0 = {.goal_topic = "/uav0/goal", .path_topic = "/uav0/path"};

TEST(GoalSubscriber, WhatIsRefusedIsCountedAndReportedOnce) {
  const Domain domain{test::own_network()};
  GoalSubscriber subscriber(domain.participant(), goals_of_uav0, {.world = 5, .floor = 0.3, .ceiling = 3});
  Operator person(domain, "uav0");
  GoalTrack track(Multirotor{}, Constant{{0, 0, 1}, 0.0}, 0.5);
  double t = 0.0;
  const auto refused = [&](const std::string& sentence) {
    EXPECT_THAT(subscriber.news(), ElementsAre(HasSubstr(sentence)));
    EXPECT_THAT(subscriber.news(), IsEmpty());
    subscriber.pass_on(t += 10.0, track);
    EXPECT_EQ(track.messages(), 0u) << sentence;
  };
  person.goal({0, std::nan(""), 1});
  refused("a goal is refused: not finite, or without an attitude");
  person.goal({0, 0, 1}, 0.0, "map");
  refused("in a frame that is not goal_frame, \"world\"");
  person.goal({6, 0, 1});
  refused("outside |x|, |y| <= 5 m, 0.3 <= z <= 3 m");
  person.goal({0, 0, 0.2});
  EXPECT_THAT(subscriber.news(), IsEmpty());
  person.path({1, 1}, {{0, 0, 1}, {1, 0, 1}});
  refused("a path whose stamps do not rise from that of its header");
  person.path({}, {});
  refused("a path that has not 1 to 64 poses");
  person.path({1, 1.1}, {{0, 0, 1}, {1, 0, 1}});
  subscriber.pass_on(900.0, track);
  EXPECT_EQ(track.messages(), 0u);
  EXPECT_THAT(subscriber.news(), ElementsAre(HasSubstr("a path faster than 5 m/s")));
  EXPECT_THAT(subscriber.counts(), HasSubstr("0 goals taken, 1 refused: not finite"));
  EXPECT_THAT(subscriber.counts(), HasSubstr("2 refused: outside"));
}

TEST(GoalSubscriber, AGoalOnTheWrongSideOfAZoneIsRefused) {
  const Domain domain{test::own_network()};
  const Zone pond{.polygon = {{1, -1}, {3, -1}, {3, 1}, {1, 1}}};
  GoalSubscriber subscriber(domain.participant(), goals_of_uav0, {.world = 5, .zones = {pond}});
  Operator person(domain, "uav0");
  GoalTrack track(Multirotor{}, Constant{{0, 0, 1}, 0.0}, 0.5);
  person.goal({2, 0.5, 1});
  EXPECT_THAT(subscriber.news(), ElementsAre(HasSubstr("or on the wrong side of a [[safety.zone]]")));
  subscriber.pass_on(10.0, track);
  EXPECT_EQ(track.messages(), 0u);
  person.goal({4, 0.5, 1});
  subscriber.pass_on(20.0, track);
  EXPECT_EQ(track.messages(), 1u);
}

TEST(GoalSubscriber, OfGoalsThatComeFasterThanTenASecondTheLastIsTaken) {
  const Domain domain{test::own_network()};
  GoalSubscriber subscriber(domain.participant(), goals_of_uav0, {});
  Operator person(domain, "uav0");
  GoalTrack track(Multirotor{}, Constant{{0, 0, 1}, 0.0}, 0.5);
  person.goal({9, 9, 9});
  subscriber.forget();
  std::vector<Waypoint> received;
  for (int period = 0; period < 100; ++period) {
    if (period < 95) person.goal({0.1 * period, 0, 1});
    subscriber.pass_on(0.01 * period, track);
  }
  EXPECT_LE(track.messages(), 10u);
  EXPECT_GE(track.messages(), 9u);
  track.waypoints(0, received);
  EXPECT_EQ(received[0].p.x, 0.0);
  track.waypoints(track.messages() - 1, received);
  EXPECT_NEAR(received[0].p.x, 9.4, 0.5);
  EXPECT_THAT(subscriber.news(), IsEmpty());
}

TEST(GoalSubscriber, AGoalThatIsSentInFlightMovesTheRobotThereAndARefusedOneDoesNot) {
  std::string text = row_of({"1.16", "1.16"}, 5.0).text;
  const std::string place = "namespace = \"/px4_0\"\n";
  text.insert(text.find(place), "goal_topic = \"/uav0/goal\"\npath_topic = \"/uav0/path\"\n");
  Rig rig(test::scenario_of(text));
  Operator person(*rig.domain, "uav0");
  person.goal({2, 2, 2});  // before the flight: of no account
  const LoopOutcome outcome = rig.fly(0.3, [&] {
    person.goal({-0.8, 0.8, 1.2});
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    person.goal({1e6, 0, 1});
  });
  EXPECT_GE(outcome.updates + outcome.missed, 500) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  const Motion m = rig.vehicle(0).motion();
  EXPECT_NEAR(m.p.x, -0.8, 0.1);
  EXPECT_NEAR(m.p.y, 0.8, 0.1);
  EXPECT_THAT(rig.reported, Contains(HasSubstr("uav0: a goal is refused: outside")));
  EXPECT_THAT(rig.world->counts(), Contains(HasSubstr("uav0: 1 goals taken, 1 refused: outside")));
  expect_well_treated(rig);
}

using FlyGoals = FlyTest;

TEST_F(FlyGoals, AFlightWithGoalsAndAPathIsReplayedBitForBit) {
  std::filesystem::path fleet = desk("4.5");
  std::string text = test::read_file(fleet);
  const std::string place = "namespace = \"/px4_2\"";
  text.insert(text.find(place), "goal_topic = \"/uav1/goal\"\npath_topic = \"/uav1/path\"\n");
  std::ofstream(fleet) << text;
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto flyer = begin(flight(fleet), "fly");
  {
    const Domain domain{test::own_network()};
    Operator person(domain, "uav1");
    ASSERT_TRUE(prints("fly.err", "the task begins")) << printed("fly.err");
    ASSERT_TRUE(test::eventually([&] { return person.is_received(); }, std::chrono::seconds(5)));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    person.goal({0.3, 0.6, 1.2});
    std::this_thread::sleep_for(std::chrono::milliseconds(1000));
    person.path({1.0, 1.5, 2.5}, {{0.0, 0.5, 1.0}, {-0.2, 0.3, 1.1}, {0.0, 0.0, 1.0}});
    person.goal({0, 0, 50});
    EXPECT_TRUE(test::eventually([&] { return flyer->ended(); }, std::chrono::seconds(30)));
  }
  EXPECT_EQ(flyer->code(), 0) << printed("fly.err");
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("fly.err"), HasSubstr("uav1: 2 goals taken, 1 refused: outside"));
  EXPECT_THAT(printed("fly.err"), HasSubstr("uav1: a goal is refused: outside"));
  expect_replayed("flown");
}

}  // namespace
}  // namespace sightline::dds
