/// Links to robots that are not simulated, [fleet] and [agent.NAME.link]; reading them needs no DDS.
#pragma once

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "bridges/dds/fleet/link_fault.hpp"
#include "sightline/base.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

class TomlTable;

namespace dds {
class LinkEnd;
class VehicleSimulator;
struct EndSetup;
struct SimulatorSetup;
}  // namespace dds

// Each kind of link offers, beside its parameters:
//   read             its keys; in read_link.cpp
//   commanded_by     the key and the topic, or the prefix of topics, for commands to a robot
//   is_commanded_on  whether only a program that flies the robot publishes this topic
//   describe         the topics of the link
//   end, simulator   the two ends of the link; in links/ and simulators/
// A kind with local_frame = true has an estimator with a frame of its own.

/// PX4 releases whose messages are supported.
enum class Px4Release { v1_14, v1_15, v1_16, v1_17, v1_18 };

/// A PX4 vehicle behind its uXRCE-DDS agent.
struct Px4Link {
  static constexpr std::string_view name = "px4";
  static constexpr bool local_frame = true;

  Px4Release release = Px4Release::v1_16;
  std::string name_space{};  ///< of its topics, "/px4_1"; empty: none
  int target_system = 0;     ///< required MAV_SYS_ID; 0: any
  double battery_min = 0.2;  ///< remaining charge below which it is not armed, 0 to 1
  double reset_max = 0.3;    ///< sum of its estimator's jumps that are attributed to its local frame [m]

  static Px4Link read(const TomlTable& at, const std::string& agent);
  std::pair<std::string_view, std::string> commanded_by() const { return {"namespace", name_space}; }
  bool is_commanded_on(std::string_view topic) const {
    for (const char* message : {"/fmu/in/trajectory_setpoint", "/fmu/in/offboard_control_mode"}) {
      const std::string plain = name_space + message;  // PX4 appends a message's version
      if (topic == plain || topic.starts_with(plain + "_v")) return true;
    }
    return false;
  }
  std::string describe() const {
    return fmt::format("{} of PX4 1.{}", name_space.empty() ? "topics without a namespace" : name_space,
                       14 + static_cast<int>(release));
  }
  std::unique_ptr<dds::LinkEnd> end(const dds::EndSetup& setup) const;
  std::unique_ptr<dds::VehicleSimulator> simulator(const dds::SimulatorSetup& setup) const;

  static constexpr auto parameters() {
    constexpr std::array<std::string_view, 5> releases = {"1.14", "1.15", "1.16", "1.17", "1.18"};
    return Parameters{parameter("release", &Px4Link::release, releases, "release of its firmware"),
                      parameter("target_system", &Px4Link::target_system, "", {1, 255, "1 to 255"},
                                "MAV_SYS_ID that it must have; none: any"),
                      parameter("battery_min", &Px4Link::battery_min, "", {0, 1, "0 to 1"},
                                "charge that must be left before a flight; full: 1"),
                      parameter("reset_max", &Px4Link::reset_max, "m", {0.0, 100.0, "0 to 100"},
                                "jumps of its estimator, in sum, that are taken as its frame's")};
  }
};

/// Variables of a Crazyflie's log with its IMU: angular velocity [deg/s] and specific force [g] in B.
inline constexpr std::array<std::string_view, 6> crazyflie_imu = {"gyro.x", "gyro.y", "gyro.z",
                                                                  "acc.x",  "acc.y",  "acc.z"};
inline constexpr double crazyflie_gyro_unit = std::numbers::pi / 180;  // [rad/s]

/// A Crazyflie behind the Crazyswarm2 server.
struct Crazyswarm2Link {
  static constexpr std::string_view name = "crazyswarm2";

  std::string name_space{};  ///< of its topics and services, "/cf1"
  double takeoff_height = 0.5, takeoff_time = 2.0;
  double battery_min = 3.7;  ///< voltage below which it is not armed [V]
  std::string imu{};         ///< topic of the log with its IMU; empty: none
  std::vector<std::string> imu_vars{crazyflie_imu.begin(), crazyflie_imu.end()};  ///< of that log, in order

  static Crazyswarm2Link read(const TomlTable& at, const std::string& agent);
  std::pair<std::string_view, std::string> commanded_by() const { return {"namespace", name_space}; }
  bool is_commanded_on(std::string_view topic) const { return topic.starts_with(name_space + "/cmd_"); }
  std::string describe() const { return fmt::format("{} of Crazyswarm2", name_space); }
  std::unique_ptr<dds::LinkEnd> end(const dds::EndSetup& setup) const;
  std::unique_ptr<dds::VehicleSimulator> simulator(const dds::SimulatorSetup& setup) const;

  static constexpr auto parameters() {
    return Parameters{parameter("takeoff_height", &Crazyswarm2Link::takeoff_height, "m",
                                {0.1, 10, "0.1 to 10"}, "above the ground, where the task begins"),
                      parameter("takeoff_time", &Crazyswarm2Link::takeoff_time, "s", {0.5, 20, "0.5 to 20"},
                                "from the ground to there"),
                      parameter("battery_min", &Crazyswarm2Link::battery_min, "V", {2.5, 30, "2.5 to 30"},
                                "that its battery must have before a flight")};
  }
};

/// Interface that takes a ROS 2 robot off and lands it.
enum class FlightCalls {
  topics,   ///< std_msgs/Empty
  empty,    ///< services of std_srvs/Empty
  trigger,  ///< services of std_srvs/Trigger
};
/// Meaning of the numbers in its cmd_vel.
enum class FlightCommands {
  velocity,    ///< [m/s], [rad/s]
  normalised,  ///< inputs of (24), within [-1, 1]
};

/// A robot with an odometry and a cmd_vel topic: rovers, and multirotors that accept velocities.
struct Ros2Link {
  static constexpr std::string_view name = "ros2";

  std::string odometry{}, cmd_vel{};  ///< topics
  bool stamped = false;               ///< cmd_vel is a TwistStamped
  std::string frame{}, body_frame{};  ///< required frames of the odometry: parent and child; empty: any

  // Of a robot that flies.
  std::string takeoff{}, land{};  ///< topics or services
  FlightCalls calls = FlightCalls::topics;
  FlightCommands commands = FlightCommands::velocity;
  std::string state{};  ///< topic of its state; empty: none

  bool flies() const { return !takeoff.empty(); }

  static Ros2Link read(const TomlTable& at, const std::string& agent);
  std::pair<std::string_view, std::string> commanded_by() const { return {"cmd_vel", cmd_vel}; }
  bool is_commanded_on(std::string_view topic) const { return topic == cmd_vel; }
  std::string describe() const {
    return odometry.empty() ? cmd_vel : fmt::format("{} and {}", odometry, cmd_vel);
  }
  std::unique_ptr<dds::LinkEnd> end(const dds::EndSetup& setup) const;
  std::unique_ptr<dds::VehicleSimulator> simulator(const dds::SimulatorSetup& setup) const;

  static constexpr auto parameters() {
    constexpr std::array<std::string_view, 3> calls = {"topics", "empty", "trigger"};
    constexpr std::array<std::string_view, 2> commands = {"velocity", "normalised"};
    return Parameters{parameter("calls", &Ros2Link::calls, calls, "what takeoff and land are"),
                      parameter("commands", &Ros2Link::commands, commands, "what its cmd_vel is in")};
  }
};

/// Source of poses: the robot's own odometry; mocap or tf, in G and without velocities; or the
/// estimator of a vision-localized robot, which uses the motion of the robot's odometry and its
/// camera's detections.
enum class PoseSource { odometry, mocap, tf, estimate };
inline constexpr std::array<std::string_view, 4> pose_sources = {"odometry", "mocap", "tf", "estimate"};

struct PosesFrom {
  PoseSource source = PoseSource::odometry;
  bool by_others() const { return source == PoseSource::mocap || source == PoseSource::tf; }
  bool estimated() const { return source == PoseSource::estimate; }

  std::string topic{};  ///< of mocap: PoseStamped, or NamedPoseArray if the body has a name
  std::string name{};   ///< of the body in a NamedPoseArray; of tf, the frame of the body
  std::string frame =
      "world";  ///< name of G: for mocap the frame of its poses, for tf the root of the chain of parents
};

/// Pose of a local frame in G.
struct LinkOrigin {
  Vec3<double> p{};      ///< [m]
  double heading = 0.0;  ///< of its x axis, if the frame is ENU [rad]
};

/// Goals for the robot in flight.
struct GoalsFrom {
  std::string goal_topic{};     ///< of PoseStamped; empty: none
  std::string path_topic{};     ///< of Path, whose poses have stamps; empty: none
  std::string frame = "world";  ///< name of G
  double speed = 0.5;           ///< towards goals [m/s]
};

/// The kinds of links, by their words in files.
using LinkKind = std::variant<Px4Link, Crazyswarm2Link, Ros2Link>;

struct Link {
  BodyId robot{};
  LinkKind kind{};
  LinkOrigin origin{};  ///< of the frame of its odometry and its velocity commands
  PosesFrom poses{};
  GoalsFrom goals{};
  bool has_camera = false;

  /// "px4"
  std::string_view kind_name() const {
    return std::visit([](const auto& k) { return std::string_view(k.name); }, kind);
  }
  bool has_local_frame() const {
    return std::visit(
        [](const auto& k) {
          return requires { k.local_frame; };
        },
        kind);
  }
};

/// Discovery and addressing on the network.
enum class Multicast { off, on };
struct FleetNetwork {
  int domain = 0;                                  ///< of DDS
  std::vector<std::string> interfaces = {"lo"};    ///< for outgoing messages, by name
  std::vector<std::string> peers = {"127.0.0.1"};  ///< machines that receive discovery requests
  Multicast multicast = Multicast::off;
  int participants = 32;            ///< greatest number of programs on one machine
  std::filesystem::path keys{};     ///< DDS security: a folder for each of key_owners; empty: none
  std::string node = "/sightline";  ///< name of the flight node, prefix of its topics and services
  bool topics = true;               ///< publishes the flight to other nodes
};
inline constexpr int domain_max = 230;
/// Owners of keys in a fleet, and the files of each, by their names in SROS 2.
inline constexpr std::array<std::string_view, 2> key_owners = {"flyer", "vehicles"};
inline constexpr std::array<std::string_view, 6> key_files = {
    "identity_ca.cert.pem",    "cert.pem",       "key.pem",
    "permissions_ca.cert.pem", "governance.p7s", "permissions.p7s"};

/// A target or an obstacle whose pose other nodes publish; or a robot that another part of the team
/// plans.
struct BodyLink {
  BodyId body{};
  PosesFrom poses{};
  std::optional<Link> robot{};  ///< its link, for reception only; its id is that of the whole team
};

struct FleetPlan final : Links {
  FleetNetwork network{};
  std::vector<Link> links{};        ///< of each robot, in the order of the team
  std::vector<BodyLink> bodies{};   ///< of the bodies that have a link, in the order of the team
  std::vector<LinkFault> faults{};  ///< of the vehicle simulators

  std::string describe(const Team& team) const override;
  std::shared_ptr<const Links> of_part(const ScenarioSpec& whole, const ScenarioSpec& part) const override;
};

/// The links of a scenario.
/// @throws std::invalid_argument without [fleet]
const FleetPlan& fleet_of(const ScenarioSpec& scenario);
/// The same for changes: a copy that no other scenario shares.
FleetPlan& own_fleet(ScenarioSpec& scenario);

/// Whether the robot behind a link can have a fault of that kind.
bool can_have(const Link& link, LinkFaultKind kind);

}  // namespace sightline
