#include "bridges/dds/doctor.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <thread>

#include "bridges/dds/links/px4_layout.hpp"
#include "bridges/dds/simulators/ros2_rover.hpp"
#include "sightline/base/now.hpp"
#include "sightline/registry.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"

extern "C" {
#include "px4.h"
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// A fleet, its stand-ins, and who listens to them.
class Ward {
 public:
  explicit Ward(const Scenario& fleet) : Ward(fleet, fleet) {}
  Ward(const Scenario& fleet, const Scenario& vehicles)
      : domain(std::make_shared<Domain>(fleet_of(fleet).network)),
        vehicle_simulators(vehicles, domain),
        stepping([this] { vehicle_simulators.run(1e9, done, {}); }),
        doctor(fleet, domain),
        other(domain->another_participant()) {}
  ~Ward() {
    done = 1;
    stepping.join();
  }

  Px4Vehicle& vehicle(std::size_t i) { return dynamic_cast<Px4Vehicle&>(vehicle_simulators.of(i)); }

  /// Waits, at most 8 s, until all that is found is as light as that.
  std::vector<Finding> until(Light light) {
    return seen_until(doctor, [&](const auto& all) { return !all.empty() && worst(all) == light; });
  }
  /// Waits until it is found, and says what else is where it is not.
  testing::AssertionResult finds(const std::string& robot, Aspect aspect, Light light,
                                 const std::string& part) {
    return found_by(doctor, robot, aspect, light, part);
  }

  template <class So>
  static std::vector<Finding> seen_until(FleetDoctor& doctor, So&& so) {
    std::vector<Finding> all;
    for (int k = 0; k < 80; ++k) {
      all = doctor.findings();
      if (so(all)) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return all;
  }
  static testing::AssertionResult found_by(FleetDoctor& doctor, const std::string& robot, Aspect aspect,
                                           Light light, const std::string& part) {
    const auto is = [&](const Finding& f) {
      return f.robot == robot && f.aspect == aspect && f.light == light &&
             f.sentence.find(part) != std::string::npos;
    };
    const std::vector<Finding> all =
        seen_until(doctor, [&](const auto& seen) { return std::any_of(seen.begin(), seen.end(), is); });
    if (std::any_of(all.begin(), all.end(), is)) return testing::AssertionSuccess();
    return testing::AssertionFailure() << findings_table(all, false);
  }

  Interrupts done{0};
  std::shared_ptr<Domain> domain;
  DdsVehicleSimulators vehicle_simulators;
  std::thread stepping;
  DdsDoctor doctor;
  dds_entity_t other;
};

std::set<Aspect> aspects_of(const std::vector<Finding>& all, const std::string& robot) {
  std::set<Aspect> aspects;
  for (const Finding& finding : all)
    if (finding.robot == robot) aspects.insert(finding.aspect);
  return aspects;
}

TEST(Doctor, VehiclesOfEachReleaseAreGreenInAllThatIsLookedAtAndNothingIsSentToThem) {
  Ward ward(row_of({"1.14", "1.15", "1.16", "1.17", "1.18"}, 1.0));
  std::vector<Finding> all = ward.until(Light::green);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  all = ward.doctor.findings();
  EXPECT_EQ(worst(all), Light::green) << findings_table(all, false);
  for (std::size_t i = 0; i < 5; ++i) {
    const std::string name = fmt::format("uav{}", i);
    EXPECT_EQ(aspects_of(all, name).size(), 14u) << name;  // each aspect of a robot
    EXPECT_TRUE(ward.finds(name, Aspect::release, Light::green,
                           i == 0 ? "cannot be requested before 1.15" : "it takes what we send"));
    const Px4VehicleCounts n = ward.vehicle(i).reported();
    EXPECT_EQ(n.setpoints + n.heartbeats + n.arm_requests + n.offboard_requests, 0) << i;
  }
  EXPECT_EQ(aspects_of(all, ""), std::set<Aspect>{Aspect::distance});
  // Nobody could take it for a flyer.
  const Surroundings around = DiscoveryMonitor(ward.other).look();
  for (const char* topic : {"trajectory_setpoint", "offboard_control_mode", "vehicle_command"})
    EXPECT_THAT(around.writers_of(fmt::format("rt/px4_2/fmu/in/{}", topic)), IsEmpty());
  EXPECT_EQ(around.writers_of("rt/px4_2/fmu/in/message_format_request").size(), 1u);
}

TEST(Doctor, AVehicleThatTakesOtherLayoutsThanItSpeaksSaysSo) {
  Ward ward(row_of({"1.15"}, 1.0));
  ward.vehicle(0).aside().take_layouts_of(14);
  EXPECT_TRUE(ward.finds(
      "uav0", Aspect::release, Light::red,
      "it takes the /fmu/in/vehicle_command of PX4 1.14, by its own answer; expected that of 1.15"));
}

TEST(Doctor, WhatAVehicleSaysOfItselfIsFound) {
  Scenario vehicles = row_of({"1.16", "1.17"}, 1.0);
  Scenario fleet = vehicles;
  std::get<Px4Link>(own_fleet(fleet).links[0].kind).target_system = 77;
  Ward ward(fleet, vehicles);
  EXPECT_TRUE(ward.finds("uav0", Aspect::system, Light::red, "it is system 1, expected 77"));
  Px4Vehicle& vehicle = ward.vehicle(1);
  vehicle.aside().set_battery(0.12F);
  EXPECT_TRUE(ward.finds("uav1", Aspect::battery, Light::red, "12 %, 13.4 V, expected battery_min = 20 %"));
  Faults& faults = ward.vehicle_simulators.faults(1);
  faults.begin(Kind::battery_low);
  EXPECT_TRUE(ward.finds("uav1", Aspect::battery, Light::red, "5 %, 13.2 V, which it says is critical"));
  vehicle.aside().lose_transmitter(true);
  EXPECT_TRUE(ward.finds("uav1", Aspect::pilot, Light::red, "it receives no pilot's transmitter"));
  faults.begin(Kind::estimator_invalid);
  vehicle.fail_checks(true);
  EXPECT_TRUE(ward.finds("uav1", Aspect::checks, Light::red,
                         "its own checks before a flight do not pass (local_position_invalid)"));
  EXPECT_TRUE(
      ward.finds("uav1", Aspect::estimator, Light::red, "its estimator is not valid: xy, z, v_xy, v_z"));
  faults.end(Kind::estimator_invalid);
  vehicle.aside().set_alignment(false, true);
  EXPECT_TRUE(
      ward.finds("uav1", Aspect::estimator, Light::red, "its estimator has not found yet what is level"));
  vehicle.aside().set_alignment(true, false);
  EXPECT_TRUE(ward.finds("uav1", Aspect::estimator, Light::red, "its estimator has no heading yet"));
  vehicle.aside().set_alignment(true, true);
  EXPECT_TRUE(
      ward.finds("uav1", Aspect::estimator, Light::green, "; it knows what is level, and its heading"));
  vehicle.fail_checks(false);
  Writer<px4_msgs_msg_dds__VehicleCommand_15_> someone(ward.other, px4_msgs_msg_dds__VehicleCommand_15__desc,
                                                       "/px4_1/fmu/in/vehicle_command", of_sensors);
  px4_msgs_msg_dds__VehicleCommand_15_ arm{};
  arm.command = 400, arm.param1 = 1.0F, arm.target_system = 2;
  for (int k = 0; k < 50 && !vehicle.armed(); ++k)
    someone(arm), std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_TRUE(ward.finds("uav1", Aspect::state, Light::red, "it is armed already"));
}

TEST(Doctor, WhoElseSpeaksOrSteersIsFound) {
  Ward ward(row_of({"1.16", "1.16"}, 1.0));
  ward.until(Light::green);
  RawWriter setpoints(ward.other, px4_msgs_msg_dds__TrajectorySetpoint__desc,
                      "/px4_0/fmu/in/trajectory_setpoint", of_sensors);
  EXPECT_TRUE(ward.finds("uav0", Aspect::writers, Light::red, "another program writes set-points"));
  RawWriter heartbeats(ward.other, px4_msgs_msg_dds__OffboardControlMode_15__desc,
                       "/px4_0/fmu/in/offboard_control_mode", of_sensors);
  EXPECT_TRUE(ward.finds("uav0", Aspect::writers, Light::red, "another flyer"));
  Writer<px4_msgs_msg_dds__VehicleOdometry_> second(ward.other, px4_msgs_msg_dds__VehicleOdometry__desc,
                                                    "/px4_1/fmu/out/vehicle_odometry", of_px4_output);
  ASSERT_TRUE(test::eventually([&] { return second.matched() > 0; }));
  second({});
  EXPECT_TRUE(ward.finds("uav1", Aspect::writers, Light::red, "1 messages of a second writer"));
}

TEST(Doctor, WhereRobotsAreIsComparedWithTheWallsAndWithEachOther) {
  const Scenario vehicles = row_of({"1.16", "1.16"}, 1.0);
  Scenario fleet = vehicles;
  own_fleet(fleet).links[1].origin.p = {3.0, 200.1, 0.2};
  {
    Ward ward(fleet, vehicles);
    EXPECT_TRUE(ward.finds("uav1", Aspect::place, Light::red, "beyond world = 100 m: is its origin right?"));
    EXPECT_TRUE(ward.finds("uav0", Aspect::place, Light::green, "at [0.00, 0.00, 0.00] m in G"));
    EXPECT_TRUE(ward.finds("", Aspect::distance, Light::green, "d_hard = 0.6 m: none is nearer"));
  }
  {
    Scenario elsewhere = vehicles;
    own_fleet(elsewhere).links[0].origin.p.y -= 4.0, own_fleet(elsewhere).links[1].origin.p.z += 489.0;
    Ward ward(vehicles, elsewhere);
    EXPECT_TRUE(ward.finds("uav0", Aspect::place, Light::red, "[0.00, 4.00, -0.60] m from its start"));
    EXPECT_TRUE(ward.finds("uav1", Aspect::place, Light::red, "below the ground at 0.2 m"));
  }
  {
    Scenario pond = vehicles;
    pond.safety->barrier_options.zones = {Zone{.polygon = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}}};
    Ward ward(pond, vehicles);
    EXPECT_TRUE(ward.finds("uav0", Aspect::place, Light::red, "not outside safety.zone[0]: is its origin"));
  }
  own_fleet(fleet).links[1].origin.p = fleet_of(vehicles).links[0].origin.p;  // forgotten in a copy
  fleet.safety->supervisor->times.fresh = 0.02;
  Ward ward(fleet, vehicles);
  EXPECT_TRUE(ward.finds("", Aspect::distance, Light::red, "uav0 and uav1 are 0.00 m apart, d_hard = 0.6 m"));
  EXPECT_TRUE(ward.finds("", Aspect::origins, Light::red, "uav0 and uav1 say one origin and one place"));
  EXPECT_TRUE(ward.finds("uav0", Aspect::rate, Light::red,
                         "levels flap unless safety.supervisor.fresh = 0.02 s is 0.025 s or more"));
}

/// Vehicles by hand: what they say is what the test says.
class ByHand {
 public:
  struct Robot {
    Writer<px4_msgs_msg_dds__VehicleOdometry_> odometry;
    Writer<px4_msgs_msg_dds__VehicleLocalPosition_16_> position;
    Writer<px4_msgs_msg_dds__VehicleLandDetected_> landed;
    Writer<px4_msgs_msg_dds__VehicleStatus_16_> status;
    double ahead = 0.0, drift = 0.0, late = 0.0;  // of its clock [s], [s/s]; of every 10th message [s]
    std::uint8_t frame = 1;
    float north = 0.0F;
    bool valid = true, global = false;
    double longitude = 0.0;
  };

  ByHand(const Scenario& fleet, std::size_t robots)
      : domain(std::make_shared<Domain>(fleet_of(fleet).network)),
        doctor(fleet, domain),
        other(domain->another_participant()) {
    for (std::size_t i = 0; i < robots; ++i) {
      const auto topic = [&](const char* name) { return fmt::format("/px4_{}/fmu/out/{}", i, name); };
      all.emplace_back(new Robot{
          {other, px4_msgs_msg_dds__VehicleOdometry__desc, topic("vehicle_odometry"), of_px4_output},
          {other, px4_msgs_msg_dds__VehicleLocalPosition_16__desc, topic("vehicle_local_position"),
           of_px4_output},
          {other, px4_msgs_msg_dds__VehicleLandDetected__desc, topic("vehicle_land_detected"), of_px4_output},
          {other, px4_msgs_msg_dds__VehicleStatus_16__desc, topic("vehicle_status_v1"), of_px4_output}});
    }
  }
  /// 100 Hz, for so long [s].
  void speak(double seconds) {
    for (const std::int64_t end = monotonic_now() + std::llround(1e9 * seconds); monotonic_now() < end; ++k) {
      for (const auto& robot : all) say(*robot);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  testing::AssertionResult finds(std::size_t i, Aspect aspect, Light light, const std::string& part) {
    return Ward::found_by(doctor, fmt::format("uav{}", i), aspect, light, part);
  }

  std::shared_ptr<Domain> domain;
  DdsDoctor doctor;
  dds_entity_t other;
  std::vector<std::unique_ptr<Robot>> all;
  int k = 0;

 private:
  void say(Robot& robot) {
    const double t = 0.01 * k;
    const double clock = robot.ahead + robot.drift * t - (k % 10 == 9 ? robot.late : 0.0);
    const auto now = static_cast<std::uint64_t>(realtime_now() / 1000 + std::llround(1e6 * clock));
    px4_msgs_msg_dds__VehicleOdometry_ m{};
    m.timestamp = m.timestamp_sample = now;
    m.pose_frame = m.velocity_frame = robot.frame;
    m.q[0] = 1.0F, m.position[0] = robot.north;
    robot.odometry(m);
    if (k % 10 != 0) return;
    px4_msgs_msg_dds__VehicleLocalPosition_16_ p{};
    p.xy_valid = p.v_xy_valid = robot.valid, p.z_valid = p.v_z_valid = true;
    p.xy_global = p.z_global = robot.global;
    p.ref_lon = robot.longitude;
    robot.position(p);
    px4_msgs_msg_dds__VehicleLandDetected_ l{};
    l.landed = robot.valid;
    robot.landed(l);
    px4_msgs_msg_dds__VehicleStatus_16_ s{};
    s.failsafe = !robot.valid, s.pre_flight_checks_pass = true;
    robot.status(s);
  }
};

TEST(Doctor, ClocksThatDifferOrDriftAndMessagesThatAreLateAreFound) {
  ByHand fleet(row_of({"1.16", "1.16", "1.16", "1.16", "1.16"}, 1.0), 5);
  fleet.all[0]->ahead = 0.05;
  fleet.all[1]->ahead = -0.05;
  fleet.all[2]->ahead = -1e-9 * static_cast<double>(realtime_now()) + 20.0;  // since its start
  fleet.all[3]->drift = -0.08;                                               // its clock is slower
  fleet.all[4]->late = 0.08;
  fleet.speak(4.5);
  EXPECT_TRUE(fleet.finds(0, Aspect::clock, Light::red, "s ahead of ours, expected 0.03 s at most"));
  EXPECT_TRUE(fleet.finds(1, Aspect::clock, Light::red, "s behind ours, or no pose is faster on its way"));
  EXPECT_TRUE(fleet.finds(2, Aspect::clock, Light::red, "of its start, or of a simulation"));
  EXPECT_TRUE(fleet.finds(3, Aspect::clock, Light::red, "drift apart by"));
  EXPECT_TRUE(fleet.finds(4, Aspect::latency, Light::red, "expected 50 ms at most"));
}

TEST(Doctor, FramesEstimatorsAndOriginsOfVehiclesAreFound) {
  ByHand fleet(row_of({"1.16", "1.16", "1.16"}, 1.0), 3);
  fleet.all[0]->frame = 2;
  fleet.all[1]->valid = false;
  for (const std::size_t i : {1u, 2u}) fleet.all[i]->global = true;
  fleet.all[2]->longitude = 1e-3;  // 111 m to the east, where the fleet says 3
  fleet.speak(1.0);
  EXPECT_TRUE(fleet.finds(0, Aspect::frames, Light::red, "poses in frames that are not NED"));
  EXPECT_TRUE(fleet.finds(1, Aspect::estimator, Light::red, "its estimator is not valid: xy, v_xy"));
  EXPECT_TRUE(fleet.finds(1, Aspect::checks, Light::red, "its failsafe acts"));
  EXPECT_TRUE(fleet.finds(1, Aspect::state, Light::red, "it is not on the ground"));
  EXPECT_TRUE(fleet.finds(1, Aspect::battery, Light::unknown, "it does not report a battery"));
  EXPECT_TRUE(fleet.finds(1, Aspect::pilot, Light::unknown,
                          "does not report whether it receives a pilot's transmitter"));
  EXPECT_TRUE(fleet.finds(1, Aspect::topics, Light::red,
                          "rt/px4_1/fmu/in/trajectory_setpoint: it has no subscriber"));
  EXPECT_TRUE(Ward::found_by(fleet.doctor, "", Aspect::origins, Light::red, "uav2 began ["));
  fleet.all[2]->longitude = 2.7e-5;  // 3.00 m
  fleet.speak(0.3);
  EXPECT_TRUE(Ward::found_by(fleet.doctor, "", Aspect::origins, Light::green, "2 origins agree"));
}

TEST(Doctor, ARobotThatIsMovedByHandANorthwardMetreShowsAsThat) {
  ByHand fleet(row_of({"1.16"}, 1.0), 1);
  EXPECT_FALSE(fleet.doctor.poses()[0].known);
  fleet.speak(0.5);
  const RobotPose before = fleet.doctor.poses()[0];
  fleet.all[0]->north = 1.0F;
  fleet.speak(0.3);
  const RobotPose after = fleet.doctor.poses()[0];
  ASSERT_TRUE(before.known && after.known);
  EXPECT_EQ(after.robot, "uav0");
  const double heading = 0.4;  // of the local frame in G
  EXPECT_NEAR(after.p.x - before.p.x, -std::sin(heading), 1e-6);
  EXPECT_NEAR(after.p.y - before.p.y, std::cos(heading), 1e-6);
  EXPECT_NEAR(after.p.z - before.p.z, 0.0, 1e-6);
  EXPECT_LT(after.age, 0.5);
}

TEST(Doctor, WhereNobodySpeaksItSaysWhatIsMissing) {
  const Scenario scenario = row_of({"1.16"}, 1.0);
  const auto domain = std::make_shared<Domain>(fleet_of(scenario).network);
  DdsDoctor doctor(scenario, domain);
  EXPECT_TRUE(Ward::found_by(doctor, "uav0", Aspect::topics, Light::red,
                             "vehicle_odometry: no message of PX4 1.16, it has no publisher"));
  EXPECT_TRUE(
      Ward::found_by(doctor, "uav0", Aspect::release, Light::unknown, "no vehicle_status of any release"));
  const dds_entity_t other = domain->another_participant();
  RawWriter wrong(other, px4_msgs_msg_dds__VehicleStatus_16__desc, "/px4_0/fmu/out/vehicle_odometry",
                  of_sensors);
  EXPECT_TRUE(Ward::found_by(doctor, "uav0", Aspect::topics, Light::red,
                             "it is written as px4_msgs::msg::dds_::VehicleStatus_"));
  RawWriter newer(other, px4_msgs_msg_dds__VehicleStatus_16__desc, "/px4_0/fmu/out/vehicle_status_v9",
                  of_sensors);
  EXPECT_TRUE(Ward::found_by(doctor, "uav0", Aspect::release, Light::red, "a newer release than 1.18"));
}

TEST(Doctor, ARoverIsLookedAtByItsTopics) {
  {
    Ward ward(rover_in("odom"));
    const std::vector<Finding> all = ward.until(Light::green);
    EXPECT_EQ(worst(all), Light::green) << findings_table(all, false);
    EXPECT_TRUE(ward.finds("r", Aspect::clock, Light::green, "of ours"));
    RawWriter rival(ward.other, geometry_msgs_msg_dds__Twist__desc, "/r/cmd_vel", of_ros_commands);
    EXPECT_TRUE(ward.finds("r", Aspect::writers, Light::red, "another program writes to it"));
    EXPECT_EQ(dynamic_cast<Ros2Rover&>(ward.vehicle_simulators.of(0)).commands(), 0);
  }
  Ward ward(rover_in("map"), rover_in("odom"));
  EXPECT_TRUE(ward.finds("r", Aspect::frames, Light::red, "other frames than frame, body_frame say"));
}

// What a shipped fleet of each kind is made of, and all kinds beside each other.
TEST(Doctor, FleetsOfAllKindsOfLinksAreGreen) {
  for (const char* name : {"crazyflies", "rover", "mixed", "mocap"}) {
    Scenario fleet =
        read_scenario(std::string(SIGHTLINE_SOURCE_DIR "/fleets/") + name + ".toml", with_links());
    own_fleet(fleet).network.domain = test::own_domain();
    Ward ward(fleet);
    const std::vector<Finding> all = ward.until(Light::green);
    EXPECT_EQ(worst(all), Light::green) << name << "\n" << findings_table(all, false);
    if (name == std::string("mocap")) {
      EXPECT_TRUE(ward.finds("cart", Aspect::rate, Light::green, "poses a second, the longest gap"));
    }
    if (name == std::string("crazyflies")) {
      EXPECT_TRUE(ward.finds("cf1", Aspect::radio, Light::green, "% arrive, latency "));
    }
  }
}

// One mechanism for all that keeps on the ground: what the doctor finds red, a flight refuses
// before it arms.
TEST(Doctor, WhatIsRedForAFlightIsRefusedByTheFlightInTheSameSentence) {
  {
    Scenario fleet = row_of({"1.16", "1.16", "1.16"}, 1.0);
    const Scenario vehicles = fleet;
    own_fleet(fleet).links[2].origin.p = fleet_of(vehicles).links[0].origin.p;
    Rig rig(fleet, vehicles, {.ready = 2.5});
    rig.vehicle(1).aside().set_battery(0.1F);
    EXPECT_FALSE(rig.take_off());
    EXPECT_THAT(rig.reported, testing::Contains("uav1: 10 %, 13.4 V, expected battery_min = 20 %"));
    EXPECT_THAT(rig.reported,
                testing::Contains(HasSubstr("fleet: uav0 and uav2 are 0.00 m apart, d_hard = 0.6 m")));
    for (const std::size_t i : {0u, 1u, 2u}) EXPECT_EQ(rig.counts_of(i).arm_requests, 0);
  }
  // A transmitter that is not received is reported, and flown without.
  Rig rig(row_of({"1.16"}, 1.0));
  rig.vehicle(0).aside().lose_transmitter(true);
  EXPECT_FALSE(rig.take_off(Arming::dry_run));
  EXPECT_THAT(rig.reported, testing::Contains("all are ready, none is armed: a dry run"));
}

TEST(Doctor, ARoverWhoseClockIsAheadIsNotDriven) {
  const Scenario scenario = rover_in("odom");
  const auto domain = std::make_shared<Domain>(fleet_of(scenario).network);
  const dds_entity_t other = domain->another_participant();
  std::atomic<int> driven{0};
  RawReader cmd_vel(other, geometry_msgs_msg_dds__Twist__desc, "/r/cmd_vel", of_ros_commands, std::nullopt,
                    Writers::all, [&](const void*, const Arrival&) { ++driven; });
  RawWriter odometry(other, nav_msgs_msg_dds__Odometry__desc, "/r/odom", {.reliable = true, .depth = 1});
  Interrupts done{0};
  std::thread speaking([&] {
    std::string frame = "odom", body = "base_link";
    for (; done == 0; std::this_thread::sleep_for(std::chrono::milliseconds(10))) {
      const RosTime now = to_ros(realtime_now() + 50'000'000);
      nav_msgs_msg_dds__Odometry_ m{};
      m.header.stamp.sec = now.sec, m.header.stamp.nanosec = now.nanosec;
      m.header.frame_id = frame.data(), m.child_frame_id = body.data();
      m.pose.pose.orientation.w = 1.0;
      odometry.write(&m);
    }
  });
  const Fields reported = not_ready(scenario, domain, 2.0);
  done = 1;
  speaking.join();
  EXPECT_THAT(reported, testing::Contains(HasSubstr("s ahead of ours, expected 0.03 s at most")));
  EXPECT_EQ(driven, 0);
}

}  // namespace
}  // namespace sightline::dds
