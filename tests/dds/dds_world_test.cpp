#include "bridges/dds/dds_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <cstring>
#include <random>
#include <thread>

#include "bridges/dds/simulators/ros2_rover.hpp"
#include "sightline/base/now.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"
#include "tests/support/refusal.hpp"

extern "C" {
#include "px4.h"
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// A flyer of one vehicle, whose odometry the test publishes.
struct OneVehicle {
  using Odometry = px4_msgs_msg_dds__VehicleOdometry_;
  OneVehicle() {
    EXPECT_TRUE(test::eventually([&] { return publish.matched() > 0; }));
  }

  Scenario scenario = row_of({"1.16"}, 1.0);
  std::shared_ptr<Domain> domain = std::make_shared<Domain>(fleet_of(scenario).network);
  DdsWorld world{scenario, domain};
  Writer<Odometry> publish{domain->another_participant(), px4_msgs_msg_dds__VehicleOdometry__desc,
                           "/px4_0/fmu/out/vehicle_odometry", of_px4_output};
};

TEST(DdsWorld, AFleetOfAllReleasesTakesOffFliesItsTaskAndLands) {
  Rig rig(row_of({"1.14", "1.15", "1.16", "1.17", "1.18"}, 4.0));
  const LoopOutcome outcome = rig.fly();
  EXPECT_GE(outcome.updates + outcome.missed, 400) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_TRUE(outcome.finite);
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(rig.state(static_cast<int>(i)), LinkState::done) << i;
    EXPECT_EQ(rig.counts_of(i).arm_requests, 1) << i;
    EXPECT_GT(rig.counts_of(i).setpoints, 350) << i;
    EXPECT_FALSE(rig.vehicle(i).armed()) << i;
    const Motion m = rig.vehicle(i).motion();  // where its circle ended
    EXPECT_NEAR(norm(m.p.x - 3.0 * static_cast<double>(i), m.p.y), 0.3, 0.2) << i;
  }
  expect_well_treated(rig);
}

// A rover by Twist, one by TwistStamped whose odometry begins elsewhere and turned, one by
// transforms, and a multirotor of PX4.
TEST(DdsWorld, AMixedFleetFliesAndDrives) {
  const auto rover = [](std::string_view name, std::string_view robot, double x, std::string_view more) {
    return fmt::format(
        "[agent.{0}]\nrobot = \"{1}\"\nstart = {{ p = [{2}, 5.0, 0.0], heading = 0.5 }}\nQ = [2, 2, 0, 0, 0, "
        "0{3}]\n"
        "reference = {{ constant = {{ p = [{4}, 5.5, 0.0], heading = 0.0 }} }}\n[agent.{0}.link]\nkind = "
        "\"ros2\"\ncmd_vel = \"/{0}/cmd_vel\"\n{5}",
        name, robot, x, robot == "omni_rover" ? ", 0" : "", x + 1.0, more);
  };
  Scenario scenario =
      row_of({"1.16"}, 5.5,
             rover("rover0", "omni_rover", 0.0, "odometry = \"/rover0/odom\"\n") +
                 rover("rover1", "unicycle", 3.0,
                       "odometry = \"/rover1/odom\"\nstamped = true\nframe = \"odom\"\norigin = { p = [3.0, "
                       "4.0, 0.1], heading = 2.0 }\n") +
                 rover("rover2", "unicycle", 6.0,
                       "poses = \"tf\"\npose_name = \"base_link\"\npose_frame = \"map\"\n"),
             "model", "off");
  Rig rig(scenario);
  const LoopOutcome outcome = rig.fly();
  EXPECT_TRUE(outcome.finite) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(outcome.max_allocations, 0);
  for (std::size_t i = 1; i < 4; ++i) {
    const auto& driven = dynamic_cast<Ros2Rover&>(rig.vehicle_simulators.of(i));
    const Motion m = driven.motion();
    EXPECT_NEAR(m.p.x, 3.0 * static_cast<double>(i) - 2.0, 0.2) << i;
    EXPECT_NEAR(m.p.y, 5.5, 0.2) << i;
    EXPECT_LT(norm(m.v), 0.05) << i;
    EXPECT_FALSE(driven.stopped_itself()) << i;
    EXPECT_EQ(rig.state(static_cast<int>(i)), LinkState::done) << i;
  }
  EXPECT_FALSE(rig.vehicle(0).armed());
}

TEST(DdsWorld, ARoverWhoseOdometryIsInAnotherFrameIsNotDriven) {
  Rig rig(rover_in("map"), rover_in("odom"), {.ready = 1.5});
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.reported, Contains(HasSubstr("poses in other frames than frame, body_frame say")));
  EXPECT_EQ(dynamic_cast<Ros2Rover&>(rig.vehicle_simulators.of(0)).commands(), 0);
}

TEST(DdsWorld, TheLatenessOfPosesIsCountedWithoutPx4) {
  Rig rig(rover_in("odom"));
  EXPECT_TRUE(test::eventually([&] { return rig.world->timing().arrival.p99 > 1e-6; }));
  EXPECT_LT(rig.world->timing().arrival.median, 0.1);
}

// Other writers are discovered while the rover is listened to: before it moves, no other state
// notices them.
TEST(DdsWorld, AnotherWriterThatIsDiscoveredLateKeepsARoverWhereItIs) {
  Rig rig(rover_in("odom"), {.ready = 2.5});
  std::unique_ptr<RawWriter> rival;
  std::thread later([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    rival = std::make_unique<RawWriter>(rig.domain->another_participant(), geometry_msgs_msg_dds__Twist__desc,
                                        "/r/cmd_vel", of_ros_commands);
  });
  EXPECT_FALSE(rig.take_off());
  later.join();
  EXPECT_THAT(rig.reported, Contains(HasSubstr("another program writes")));
  EXPECT_EQ(dynamic_cast<Ros2Rover&>(rig.vehicle_simulators.of(0)).commands(), 0);
}

TEST(DdsWorld, EachWrongPairOfReleasesIsRefusedBeforeArming) {
  const Fields releases = {"1.14", "1.15", "1.16", "1.17", "1.18"};
  Fields flown, spoken;
  for (const std::string& one : releases) {
    for (const std::string& other : releases)
      if (one != other) flown.push_back(one), spoken.push_back(other);
  }
  Rig rig(row_of(flown, 1.0), row_of(spoken, 1.0), {.ready = 2.5});
  EXPECT_FALSE(rig.take_off());
  for (std::size_t i = 0; i < flown.size(); ++i) {
    EXPECT_EQ(rig.state(static_cast<int>(i)), LinkState::done);
    EXPECT_EQ(rig.counts_of(i).arm_requests, 0);
    EXPECT_THAT(
        rig.reported,
        Contains(HasSubstr(fmt::format("uav{}: it looks like PX4 {}, by vehicle_status", i, spoken[i]))))
        << flown[i];
  }
}

TEST(DdsWorld, ADryRunArmsNothing) {
  Rig rig(row_of({"1.16", "1.16"}, 1.0));
  EXPECT_FALSE(rig.take_off(Arming::dry_run));
  EXPECT_THAT(rig.reported, Contains("all are ready, none is armed: a dry run"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(rig.counts_of(i).arm_requests, 0);
    EXPECT_EQ(rig.counts_of(i).setpoints, 0);
  }
}

TEST(DdsWorld, AnotherFlightOfTheSameVehicleIsAsTheFirst) {
  Rig rig(row_of({"1.16"}, 1.0));
  for (const int flight : {1, 2}) {
    rig.world.reset();  // one flyer at a time
    rig.world = std::make_unique<DdsWorld>(rig.scenario, rig.domain, of_vehicle_simulators({}));
    EXPECT_TRUE(rig.take_off()) << flight << fmt::format("{}", fmt::join(rig.reported, "\n"));
    rig.land();
    EXPECT_THAT(rig.world->faults(), IsEmpty()) << flight;
    EXPECT_EQ(rig.counts_of(0).arm_requests, flight);
    EXPECT_FALSE(rig.vehicle(0).armed());
  }
}

TEST(DdsWorld, RequestsThatAreLostAreRepeatedAndEachReplyIsReported) {
  Rig rig(row_of({"1.16", "1.18"}, 0.5));
  for (const std::size_t i : {0u, 1u}) rig.faults(i).begin(Kind::request_lost, 0.3);
  rig.fly();
  EXPECT_THAT(rig.world->faults(), IsEmpty()) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_GT(rig.faults(0).counts().requests_lost + rig.faults(1).counts().requests_lost, 0);
  for (const char* request : {"arm", "take off", "offboard", "land"})
    EXPECT_THAT(rig.reported, Contains(fmt::format("uav1: the request to {} is accepted", request)));
  for (const std::size_t i : {0u, 1u}) EXPECT_FALSE(rig.vehicle(i).armed()) << i;
  expect_well_treated(rig);
}

TEST(DdsWorld, AVehicleThatReceivesNoRequestIsGivenUpAfterFour) {
  Rig rig(row_of({"1.16"}, 1.0));
  rig.faults(0).begin(Kind::request_lost, 1.0);
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.world->faults(), Contains("uav0: it did not arm in time"));
  EXPECT_EQ(rig.faults(0).counts().requests_lost, 4);
}

// A vehicle that lands by its failsafe stays in offboard, where it does not pass its checks without
// heartbeats.
TEST(DdsWorld, AVehicleThatWasLeftInOffboardFliesAgain) {
  Rig rig(row_of({"1.16"}, 1.0));
  std::atomic<int> nav{0};
  std::atomic<bool> passes{true};
  RawReader status(rig.domain->another_participant(), px4_msgs_msg_dds__VehicleStatus_16__desc,
                   "/px4_0/fmu/out/vehicle_status_v1", of_sensors, std::nullopt, Writers::all,
                   [&](const void* m, const Arrival&) {
                     const auto& s = *static_cast<const px4_msgs_msg_dds__VehicleStatus_16_*>(m);
                     nav = s.nav_state, passes = s.pre_flight_checks_pass;
                   });
  ASSERT_TRUE(rig.take_off());
  rig.world.reset();
  ASSERT_TRUE(test::eventually([&] { return !rig.vehicle(0).armed() && nav == 14 && !passes; },
                               std::chrono::seconds(20)));
  rig.world = std::make_unique<DdsWorld>(rig.scenario, rig.domain, of_vehicle_simulators({}));
  EXPECT_TRUE(rig.take_off()) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_THAT(rig.reported, Contains("uav0: the request to hold is accepted"));
  rig.land();
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_TRUE(test::eventually([&] { return nav == 4 && passes; }));
}

// Its estimator has a pose by vision, and no satellites.
TEST(DdsWorld, AVehicleWithoutAGlobalOriginReceivesOne) {
  Rig rig(row_of({"1.14", "1.16"}, 1.0));
  for (const std::size_t i : {0u, 1u}) rig.vehicle(i).aside().lose_origin(true);
  EXPECT_TRUE(rig.take_off()) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  for (const std::size_t i : {0u, 1u}) EXPECT_TRUE(rig.vehicle(i).aside().has_origin()) << i;
  EXPECT_THAT(rig.reported, Contains("uav1: the request to take an origin is accepted"));
}

// PX4 holds from 0.8 m below the altitude of its take-off on. The start is above that altitude, or
// the floor is.
TEST(DdsWorld, TheTaskBeginsAtItsStartHeightAboveTheFloor) {
  for (const auto& [start, floor] : {std::pair(1.6, 0.2), std::pair(0.6, 1.2)}) {
    Scenario scenario = row_of({"1.16"}, 0.5);
    scenario.x0[2] = start, scenario.safety->barrier_options.floor = floor;
    Rig rig(scenario);
    std::atomic<float> downwards{-1.0F};
    std::atomic<double> held_at{0.0};
    const dds_entity_t other = rig.domain->another_participant();
    RawReader status(other, px4_msgs_msg_dds__VehicleStatus_16__desc, "/px4_0/fmu/out/vehicle_status_v1",
                     of_sensors, std::nullopt, Writers::all, [&](const void* m, const Arrival&) {
                       const auto nav = static_cast<const px4_msgs_msg_dds__VehicleStatus_16_*>(m)->nav_state;
                       const double height = rig.vehicle(0).motion().p.z;
                       if (nav == static_cast<std::uint8_t>(NavState::hold) && held_at < 0.1)
                         held_at = height;
                     });
    RawReader setpoints(
        other, px4_msgs_msg_dds__TrajectorySetpoint__desc, "/px4_0/fmu/in/trajectory_setpoint", of_sensors,
        std::nullopt, Writers::all, [&](const void* m, const Arrival&) {
          const float v = static_cast<const px4_msgs_msg_dds__TrajectorySetpoint_*>(m)->velocity[2];
          downwards = std::max(downwards.load(), v);
        });
    EXPECT_TRUE(rig.take_off()) << fmt::format("{}", fmt::join(rig.reported, "\n"));
    EXPECT_NEAR(rig.vehicle(0).motion().p.z, std::max(start, floor), 0.15);
    EXPECT_NEAR(held_at, std::max(start - 0.8, 0.1), 0.15);
    EXPECT_LE(downwards, 0.0F);
    rig.land();
  }
}

TEST(DdsWorld, APilotWhoTakesOneHasItForGoodAndTheOtherLands) {
  Rig rig(row_of({"1.16", "1.15"}, 20.0));
  const LoopOutcome outcome = rig.fly(0.7, [&] { rig.faults(0).begin(Kind::pilot); });
  EXPECT_FALSE(outcome.finite);
  EXPECT_LT(outcome.updates, 200);
  EXPECT_EQ(rig.state(0), LinkState::pilot);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_FALSE(rig.vehicle(1).armed());
  EXPECT_TRUE(rig.vehicle(0).armed());
  EXPECT_EQ(rig.counts_of(0).heartbeats, rig.after_task.heartbeats);  // nothing since
  EXPECT_LE(rig.counts_of(0).setpoints_outside, 1);                   // that was on its way
  EXPECT_THAT(rig.world->faults(), Contains("uav0: a pilot has it"));
  EXPECT_EQ(rig.world->ended(), "uav0: a pilot has it; the others landed");
}

// What the vehicle says is 50 ms old when it comes: until then set-points go out, as nobody can
// know better. After that none does.
TEST(DdsWorld, NoSetPointIsSentAfterAnotherModeWasHeardOf) {
  Rig rig(row_of({"1.16", "1.18"}, 20.0));
  std::atomic<std::int64_t> another_mode{0}, last_setpoint{0};
  const dds_entity_t other = rig.domain->another_participant();
  RawReader status(other, px4_msgs_msg_dds__VehicleStatus_16__desc, "/px4_0/fmu/out/vehicle_status_v1",
                   of_sensors, std::nullopt, Writers::all, [&](const void* m, const Arrival& a) {
                     const auto nav = static_cast<const px4_msgs_msg_dds__VehicleStatus_16_*>(m)->nav_state;
                     if (nav == static_cast<std::uint8_t>(NavState::position) && another_mode == 0)
                       another_mode = a.monotonic;
                   });
  RawReader setpoints(other, px4_msgs_msg_dds__TrajectorySetpoint__desc, "/px4_0/fmu/in/trajectory_setpoint",
                      of_sensors, std::nullopt, Writers::all,
                      [&](const void*, const Arrival& a) { last_setpoint = a.monotonic; });
  rig.fly(0.7, [&] {
    rig.faults(0).begin(Kind::delay, 0.05);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    rig.faults(0).begin(Kind::pilot);
  });
  EXPECT_EQ(rig.state(0), LinkState::pilot);
  ASSERT_GT(another_mode, 0);
  ASSERT_GT(last_setpoint, 0);
  EXPECT_LT(last_setpoint - another_mode, 3'000'000);  // on its way between two threads
  EXPECT_LE(rig.counts_of(0).setpoints_outside, 8);    // within the 50 ms
}

TEST(DdsWorld, WhenEachIsLostTheFlightEndsInFiveSecondsWithTheirLastPlaces) {
  Rig rig(row_of({"1.16", "1.17"}, 20.0));
  std::chrono::steady_clock::time_point lost;
  rig.fly(0.5, [&] {
    lost = std::chrono::steady_clock::now();
    for (const std::size_t i : {0u, 1u}) rig.faults(i).begin(Kind::silent);
  });
  EXPECT_LT(std::chrono::steady_clock::now() - lost, std::chrono::seconds(5));
  for (const char* place : {"uav0: last at .-?0.[0-9][0-9], ", "uav1: last at .[23].[0-9][0-9], "})
    EXPECT_THAT(rig.reported, Contains(testing::ContainsRegex(place)));
}

TEST(DdsWorld, AnEstimatorThatJumpsDuringTheTakeOffLandsAll) {
  Rig rig(row_of({"1.16", "1.18"}, 1.0));
  std::thread later([&] {
    EXPECT_TRUE(test::eventually([&] { return rig.vehicle(0).armed(); }, std::chrono::seconds(20)));
    rig.faults(0).begin(Kind::jump, 4.0);
  });
  EXPECT_FALSE(rig.take_off());
  later.join();
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav0: its estimator jumped too far"));
  for (const std::size_t i : {0u, 1u}) EXPECT_FALSE(rig.vehicle(i).armed()) << i;
}

TEST(DdsWorld, AClockThatJumpsIsFollowed) {
  for (const double jump : {-2.0, 2.0}) {
    Rig rig(row_of({"1.16", "1.16"}, 2.0));
    rig.fly(0.5, [&] { rig.faults(0).begin(Kind::clock_jump, jump); });
    EXPECT_THAT(rig.world->faults(), testing::IsEmpty()) << jump;
    EXPECT_THAT(rig.world->counts(), Contains(HasSubstr("1 jumps of its clock"))) << jump;
  }
}

TEST(DdsWorld, ASecondFlyerAndASecondOdometryAreRefusedBeforeArming) {
  Rig rig(row_of({"1.16", "1.16"}, 1.0), {.ready = 2.5});
  const dds_entity_t other = rig.domain->another_participant();
  RawWriter rival(other, px4_msgs_msg_dds__TrajectorySetpoint__desc, "/px4_0/fmu/in/trajectory_setpoint",
                  of_sensors);
  Writer<px4_msgs_msg_dds__VehicleOdometry_> second(other, px4_msgs_msg_dds__VehicleOdometry__desc,
                                                    "/px4_1/fmu/out/vehicle_odometry", of_px4_output);
  std::atomic<bool> done{false};
  std::thread writing([&] {
    while (!done) second({}), std::this_thread::sleep_for(std::chrono::milliseconds(5));
  });
  EXPECT_FALSE(rig.take_off());
  done = true;
  writing.join();
  for (const std::size_t i : {0u, 1u}) EXPECT_EQ(rig.counts_of(i).arm_requests, 0);
  EXPECT_THAT(rig.reported,
              Contains(testing::AllOf(HasSubstr("uav0: "), HasSubstr("another program writes set-points"))));
  EXPECT_THAT(
      rig.reported,
      Contains(testing::AllOf(HasSubstr("uav1: "), testing::AnyOf(HasSubstr("second writer"),
                                                                  HasSubstr("in frames that are not NED")))));
}

TEST(DdsWorld, ChecksThatDoNotPassKeepItOnTheGround) {
  Rig rig(row_of({"1.17"}, 1.0), {.ready = 1.5});
  rig.vehicle(0).fail_checks(true);
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.reported, Contains("uav0: its own checks before a flight do not pass"));
  EXPECT_THAT(rig.world->faults(), Contains("uav0: it was not ready in time"));
  EXPECT_FALSE(rig.vehicle(0).armed());
}

TEST(DdsWorld, WithoutItsFlyerAVehicleFailsSafeASecondAfterTheLastHeartbeat) {
  Rig rig(row_of({"1.16"}, 20.0));
  ASSERT_TRUE(rig.take_off());
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // nobody flies
  const Px4VehicleCounts n = rig.counts_of(0);
  EXPECT_GE(n.failsafe_after, 1.0);
  EXPECT_LE(n.failsafe_after, 1.1);
  rig.land();  // and what comes back does not take it again
  EXPECT_EQ(rig.state(0), LinkState::pilot);
  EXPECT_EQ(rig.counts_of(0).heartbeats, n.heartbeats);
}

// Numbers of any kind, in frames of any kind: what is believed of the robot is finite, and nothing
// of it is lost uncounted.
TEST(DdsWorld, OfAnyPoseThatComesOnlyThoseThatAreFiniteAreBelieved) {
  OneVehicle vehicle;
  DdsWorld& world = vehicle.world;
  std::mt19937_64 random(3);
  for (int k = 0; k < 20'000; ++k) {
    OneVehicle::Odometry m{};
    std::array<std::uint64_t, (sizeof m + 7) / 8> bits;
    for (std::uint64_t& word : bits) word = random();
    if (k % 2 == 0) std::memcpy(&m, bits.data(), sizeof m);  // else one number alone is any
    if (k % 2 == 1)
      m.q[0] = 1, m.position[k / 2 % 3] = std::bit_cast<float>(static_cast<std::uint32_t>(bits[0]));
    if (k % 4 != 0) m.pose_frame = m.velocity_frame = 1;
    vehicle.publish(m);
    const Measured seen = world.measure(0.01 * k);
    for (const double x : seen.measured) ASSERT_TRUE(std::isfinite(x)) << k;
    ASSERT_TRUE(std::isfinite(seen.stamps[0]) || seen.measured[0] == vehicle.scenario.x0[0]) << k;
  }
  EXPECT_THAT(world.counts()[0], testing::Not(HasSubstr(" 0 not finite")));
  EXPECT_THAT(world.counts()[0], testing::Not(HasSubstr(" 0 in other frames")));
}

// PX4's quaternion turns FRD to NED: nose up is a backward tilt of the thrust, right side down one
// to the right.
TEST(DdsWorld, AnAttitudeIsThatOfTheNewestPose) {
  OneVehicle vehicle;
  DdsWorld& world = vehicle.world;
  EXPECT_EQ(world.measure(0.0).attitudes[0], no_attitude);
  constexpr double yaw = 0.3, tilt = 0.2;
  const auto about = [](int axis, double angle) {
    Quaternion q = {std::cos(angle / 2), 0, 0, 0};
    (axis == 0 ? q.x : axis == 1 ? q.y : q.z) = std::sin(angle / 2);
    return q;
  };
  const auto measured = [&](const Quaternion& q) {
    OneVehicle::Odometry m{};
    m.timestamp = m.timestamp_sample = static_cast<std::uint64_t>(realtime_now() / 1000);
    m.pose_frame = m.velocity_frame = px4_frame_ned;
    const std::array<double, 4> parts = {q.w, q.x, q.y, q.z};
    for (std::size_t k = 0; k < 4; ++k) m.q[k] = static_cast<float>(parts[k]);
    const double before = world.measure(0.0).stamps[0];
    vehicle.publish(m);
    EXPECT_TRUE(test::eventually([&] { return world.measure(0.0).stamps[0] > before; }));
    return rotation(world.measure(0.0).attitudes[0]);
  };
  const Rotation pitched = measured(about(2, yaw) * about(1, tilt)),
                 rolled = measured(about(2, yaw) * about(0, tilt));
  EXPECT_NEAR(lean(pitched).x, -std::tan(tilt), 1e-6);
  EXPECT_NEAR(lean(pitched).y, 0.0, 1e-6);
  EXPECT_NEAR(lean(rolled).x, 0.0, 1e-6);
  EXPECT_NEAR(lean(rolled).y, -std::tan(tilt), 1e-6);
  for (const Rotation& R : {pitched, rolled}) {
    const Vec2<double> d = heading(R);
    EXPECT_NEAR(std::atan2(d.y, d.x), 0.4 + turned_over_yaw(yaw), 1e-6);  // origin.heading
  }
}

TEST(DdsWorld, AVehicleWithRotorsIsJudgedByItsTilt) {
  Rig rig(row_of({"1.16"}, 1.0, "[agent.uav0.vehicle]\npreset = \"x500\"\n", "rotors"));
  EXPECT_EQ(rig.fly().max_allocations, 0) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  const Vec2<double> tilt = true_sight(rig.scenario.team, BodyId{0}, rig.last).lean;
  EXPECT_EQ(tilt.x, lean(rotation(rig.last.attitudes[0])).x);
  EXPECT_GT(norm(tilt.x, tilt.y), 1e-4);
  EXPECT_LT(norm(tilt.x, tilt.y), 0.4);
}

TEST(DdsWorld, WhatItCannotFlyIsRefusedWithASentence) {
  const auto domain = std::make_shared<Domain>(test::own_network(1));
  const auto refusal = [&](const Scenario& scenario) {
    return refusal_of([&] { DdsWorld world(scenario, domain); });
  };
  EXPECT_THAT(
      refusal(row_of({"1.16"}, 1.0,
                     "[target.t]\nmotion = { circle = { centre = [9, 9, 1], radius = 1, rate = 1 } }\n")),
      HasSubstr("t moves, and no topic has its pose"));
  EXPECT_EQ(refusal(row_of({"1.16"}, 1.0, "[target.t]\np = [9, 9, 1]\n")), "");
  const std::string leaves = "[[event]]\nat = 0.5\nremove = \"uav0\"\n";
  EXPECT_EQ(refusal(row_of({"1.16", "1.16"}, 1.0, leaves)), "");
  EXPECT_THAT(
      refusal(row_of({"1.16", "1.16"}, 1.0, leaves + "[[event]]\nat = 0.8\nadd = \"uav0\"\n")),
      HasSubstr("event[1].add = \"uav0\", expected a robot with present = false, or one that an event "
                "lets hold: uav0 takes off at the start"));
  const auto of_link = [&](const std::string& robot, const std::string& link) {
    return refusal(test::scenario_of("[fleet]\n[agent.a]\nrobot = \"" + robot +
                                     "\"\nstart = { p = [0, 0, 1] }\n[agent.a.link]\nkind = \"" + link));
  };
  const std::string ros2 = "ros2\"\nodometry = \"/o\"\ncmd_vel = \"/c\"\n",
                    takes_off = "takeoff = \"/t\"\nland = \"/l\"\n";
  EXPECT_THAT(of_link("unicycle", "crazyswarm2\"\n"),
              HasSubstr("link.kind = crazyswarm2, behind which a unicycle does not drive"));
  EXPECT_THAT(of_link("multirotor", ros2), HasSubstr("link.takeoff is missing, expected it and land"));
  EXPECT_THAT(of_link("unicycle", ros2 + takes_off), HasSubstr("takeoff = /t, where a unicycle drives"));
  EXPECT_THAT(of_link("multirotor", ros2 + takes_off),
              HasSubstr("commands = velocity, which are no inputs of a multirotor"));
  EXPECT_THAT(of_link("velocity_multirotor", ros2 + takes_off + "commands = \"normalised\"\n"),
              HasSubstr("commands = normalised, which are no inputs of a velocity_multirotor"));
  EXPECT_THAT(refusal(test::scenario_of("[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n")),
              HasSubstr("fleet is missing"));
}

}  // namespace
}  // namespace sightline::dds
