#include "sightline/import/import.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "bridges/dds/fleet/link.hpp"
#include "sightline/scenario.hpp"
#include "sightline/sensors.hpp"
#include "sightline/vehicle.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/ros_bag.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::scenario_of;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string swarm = R"(# our swarm
robots:
  cf1:
    enabled: true
    uri: radio://0/80/2M/E7E7E7E701
    initial_position: [-1.0, 0.0, 0.0]
    type: plain
  cf2:
    enabled: true
    uri: radio://0/80/2M/E7E7E7E702
    initial_position: [0.5, 0.25, 0.02]
    type: marked
    role: evader
  cf3:
    enabled: false
    uri: radio://0/90/2M/E7E7E7E703
    initial_position: [0.0, 0.0, 0.0]
    type: plain
robot_types:
  plain:
    motion_capture:
      enabled: false
    big_quad: false
    battery:
      voltage_warning: 3.8
      voltage_critical: 3.6
  marked:
    motion_capture:
      tracking: vendor
      marker: default
    big_quad: true
all:
  firmware_logging:
    enabled: true
    default_topics:
      pose:
        frequency: 10 # Hz
  firmware_params:
    stabilizer: { estimator: 2, controller: 1 }
  broadcasts:
    num_repeats: 15
)";

const std::string server = "/crazyflie_server:\n  ros__parameters:\n    sim:\n      backend: np\n";

const std::string ros_camera = R"(image_width: 640
image_height: 480
camera_name: front
camera_matrix:
  rows: 3
  cols: 3
  data: [301.5, 0, 311.0,
         0, 298.25, 251.5,
         0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.28, 0.07, 0.0003, -0.0011, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
)";

const std::string chain = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.013, 0.021, -0.012, 0.002]
  distortion_model: equidistant
  intrinsics: [190.97, 190.96, 254.93, 256.89]
  resolution: [512, 512]
  rostopic: /cam0/image_raw
cam1:
  camera_model: pinhole
  distortion_coeffs: [0.1, -0.2, 0.001, 0.002]
  distortion_model: radtan
  intrinsics: [458.6, 457.2, 367.2, 248.4]
  resolution: [752, 480]
  timeshift_cam_imu: 0.01
)";

Imported imported(const std::string& text, const ImportOptions& options = {}) {
  const std::vector<ImportFile> files = {{"lab/a.yaml", text}};
  return import_texts(files, options);
}

std::string refusal(const std::string& text, const ImportOptions& options = {}) {
  return refusal_of<ScenarioError>([&] { (void)imported(text, options); });
}

/// The text with the first `from` replaced.
std::string with(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// A camera of our reader, on a robot that the tables lack.
Camera camera_of(const Imported& made) {
  const Scenario read = scenario_of(
      "[agent.uav0]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n"
      "[agent.uav0.sensor]\n" +
      made.text);
  return read.vision.cameras.at(0).camera;
}

TEST(ImportCrazyflies, EachEnabledRobotIsReadBackWithItsLink) {
  const Imported made = imported(swarm);
  EXPECT_EQ(made.what, "a fleet of 2 Crazyflies");
  const Scenario read = scenario_of(made.text);
  ASSERT_EQ(read.team.agents().size(), 2U);
  const FleetPlan& fleet = fleet_of(read);
  ASSERT_EQ(fleet.links.size(), 2U);
  const auto& cf1 = std::get<Crazyswarm2Link>(fleet.links[0].kind);
  const auto& cf2 = std::get<Crazyswarm2Link>(fleet.links[1].kind);
  EXPECT_EQ(cf1.name_space, "/cf1");
  EXPECT_EQ(cf1.battery_min, 3.6);
  EXPECT_EQ(cf2.battery_min, 3.7);
  EXPECT_EQ(fleet.links[0].poses.source, PoseSource::odometry);
  EXPECT_EQ(fleet.links[1].poses.source, PoseSource::mocap);
  EXPECT_EQ(fleet.links[1].poses.topic, "/poses");
  EXPECT_EQ(fleet.links[1].poses.name, "cf2");
  // It begins where the take-off ends, above its place on the ground.
  EXPECT_EQ(read.x0[0], -1.0);
  EXPECT_EQ(read.x0[2], cf1.takeoff_height);
  EXPECT_EQ(read.x0[7], 0.5);
  EXPECT_EQ(read.x0[8], 0.25);
  EXPECT_EQ(read.x0[9], 0.02 + cf2.takeoff_height);
  EXPECT_THAT(made.text, HasSubstr("radio://0/80/2M/E7E7E7E702"));
}

TEST(ImportCrazyflies, WhatHasNoCounterpartIsToldOnce) {
  EXPECT_THAT(
      imported(swarm).notes,
      ElementsAre(
          "robots.cf2.role has no counterpart", "not enabled, left out: cf3",
          "cf1: poses by the radio at 10 Hz, expected "
          "firmware_logging.default_topics.pose.frequency = 100",
          "cf1, cf2: the PID controller follows 0.5 s late, stabilizer.controller = 2 (Mellinger) does not",
          "cf2: big_quad has no counterpart; the simulated vehicle is a Crazyflie"));
  // A type overrides what all have, a robot its type.
  const std::string fast =
      with(swarm, "    big_quad: false\n",
           "    big_quad: false\n    firmware_logging: { default_topics: { pose: { frequency: 100 } } }\n");
  EXPECT_THAT(imported(fast).notes, Not(Contains(HasSubstr("poses by the radio"))));
  const std::vector<ImportFile> both = {{"crazyflies.yaml", swarm}, {"server.yaml", server}};
  EXPECT_THAT(import_texts(both).notes, Contains("/crazyflie_server.ros__parameters.sim has no counterpart"));
}

TEST(ImportCrazyflies, TheLogWithTheImuIsTakenWithItsVariables) {
  const std::string logs = R"(    custom_topics:
      voltage: { frequency: 1, vars: ["pm.vbat", "gyro.x"] }
      imu: { frequency: 20, vars: ["acc.x", "acc.y", "acc.z", "gyro.x", "gyro.y", "gyro.z", "pm.state"] }
    default_topics:
)";
  const Imported made = imported(with(swarm, "    default_topics:\n", logs));
  const Scenario read = scenario_of(made.text);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& link = std::get<Crazyswarm2Link>(fleet_of(read).links[i].kind);
    EXPECT_EQ(link.imu, fmt::format("/cf{}/imu", i + 1));
    EXPECT_THAT(link.imu_vars,
                ElementsAre("acc.x", "acc.y", "acc.z", "gyro.x", "gyro.y", "gyro.z", "pm.state"));
  }
  EXPECT_THAT(made.notes, Contains("cf1, cf2: its IMU by the radio at 20 Hz, expected "
                                   "firmware_logging.custom_topics.imu.frequency = 100"));
  const Imported without = imported(with(swarm, "    default_topics:\n", with(logs, "\"acc.y\", ", "")));
  EXPECT_THAT(without.text, Not(HasSubstr("imu")));
  // What a link would refuse.
  const std::string named = with(logs, "      imu:", "      imu.raw:");
  const std::string many = with(logs, "\"pm.state\"", "\"pm.state\", \"pm.vbat\", \"pm.state\"");
  for (const std::string& other : {named, many})
    EXPECT_THAT(imported(with(swarm, "    default_topics:\n", other)).text, Not(HasSubstr("imu")));
}

TEST(ImportCrazyflies, RobotsThatStartNearEachOtherKeepALesserDistance) {
  const Imported near = imported(with(swarm, "[0.5, 0.25, 0.02]", "[-0.5, 0.0, 0.0]"));
  EXPECT_THAT(near.notes, Contains("safety.d_hard = 0.4 m: two robots start 0.5 m apart"));
  EXPECT_EQ(scenario_of(near.text).safety.value().d_hard, 0.4);
  EXPECT_EQ(scenario_of(imported(swarm).text).safety.value().d_hard, 0.6);
}

TEST(ImportCrazyflies, RefusesWithPlaceKeyValueAndWhatWasExpected) {
  EXPECT_EQ(refusal(with(swarm, "[0.5, 0.25, 0.02]", "[-1.0, 0.1, 0.0]")),
            "lab/a.yaml:11: robots.cf2.initial_position = [... 3 items], expected a place at least 0.25 m "
            "from that "
            "of cf1, [-1, 0, 0]");
  EXPECT_EQ(refusal(with(swarm, "-1.0, 0.0, 0.0", "-1.0, .nan, 0.0")),
            "lab/a.yaml:6: robots.cf1.initial_position[1] = .nan, expected -90 to 90 m");
  EXPECT_EQ(refusal(with(swarm, "type: plain", "type: gone")),
            "lab/a.yaml:7: robots.cf1.type = gone, expected one of robot_types");
  EXPECT_THAT(refusal(with(swarm, "  cf1:", "  1st:")), HasSubstr("a name of 1 to 64 letters, digits and _"));
  EXPECT_THAT(refusal(with(swarm, "  cf2:", "  cf1:")),
              HasSubstr("robots.cf1 = {...}, expected each key once"));
  EXPECT_THAT(refusal(with(swarm, "    uri: radio://0/80/2M/E7E7E7E701\n", "")),
              HasSubstr("robots.cf1.uri is missing, expected its address"));
  EXPECT_THAT(refusal(with(swarm, "voltage_critical: 3.6", "voltage_critical: 0.1")),
              HasSubstr("2.5 to 30 V"));
  EXPECT_THAT(refusal("robots: {}\nrobot_types: {}\n"), HasSubstr("at least one robot with enabled: true"));
  EXPECT_THAT(refusal("robots: [1\n"), HasSubstr("cannot be read as YAML"));
  EXPECT_THAT(refusal("robots: {a: &a {b: *a}}\n"), HasSubstr("expected"));
}

TEST(ImportCamera, TheCalibrationOfRosIsReadBack) {
  const Camera camera = camera_of(imported(ros_camera));
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_THAT(camera.focal_length, ElementsAre(301.5, 298.25));
  EXPECT_THAT(camera.principal_point, ElementsAre(311.0, 251.5));
  EXPECT_EQ(camera.distortion, Distortion::plumb_bob);
  EXPECT_THAT(camera.coefficients, ElementsAre(-0.28, 0.07, 0.0003, -0.0011, 0.0));
  const Imported fisheye = imported(with(with(ros_camera, "plumb_bob", "equidistant"), ", 0.0]", "]"));
  EXPECT_EQ(camera_of(fisheye).distortion, Distortion::equidistant);
  const Imported plain = imported(with(ros_camera, "-0.28, 0.07, 0.0003, -0.0011, 0.0", "0, 0, 0, 0, 0"));
  EXPECT_EQ(camera_of(plain).distortion, Distortion::none);
  // A rectified picture would be another camera.
  EXPECT_THAT(imported(with(ros_camera, "data: [1, 0, 0, 0,", "data: [0.9, 0.1, 0, 0,")).notes,
              Contains(HasSubstr("rectification_matrix has no counterpart")));
  EXPECT_THAT(imported(ros_camera).notes, testing::IsEmpty());
}

TEST(ImportCamera, ABagHasCamerasByTheirTopics) {
  const std::filesystem::path folder = test::fresh_folder();
  const auto bag = [&](const test::BagWriter& writer) {
    std::vector<std::filesystem::path> file = {folder / "a.mcap"};
    std::ofstream(file[0], std::ios::binary) << writer.bytes("lz4");
    return file;
  };
  const std::string yaml = R"(image_width: 640
image_height: 480
camera_matrix: {data: [420.5, 0, 321, 0, 419, 243.5, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {data: [-0.25, 0.06, 0.001, -0.002, 0.0]}
)";
  const auto table = [](const Imported& made) { return made.text.substr(made.text.find("\n[")); };
  test::BagWriter writer = test::bag_of(test::LaggingFlight(0.1));
  const Imported made = import_files(bag(writer), {.agent = "uav1"});
  EXPECT_EQ(table(made), table(imported(yaml, {.agent = "uav1"})));
  EXPECT_THAT(made.text, HasSubstr("\n# The topic /camera/camera_info.\n"));
  writer.add("/wide/camera_info", "sensor_msgs/msg/CameraInfo", 1.0,
             test::camera_info("equidistant", {0.1, 0, 0, 0}));
  const auto both = bag(writer);
  EXPECT_EQ(camera_of(import_files(both, {.camera = "/wide/camera_info"})).distortion,
            Distortion::equidistant);
  EXPECT_THAT(import_files(both).notes, ElementsAre("/wide/camera_info is left out, --camera chooses it"));
  const auto refused = [&](const std::vector<std::filesystem::path>& files,
                           const ImportOptions& options = {}) {
    return refusal_of<ScenarioError>([&] { (void)import_files(files, options); });
  };
  EXPECT_THAT(refused(both, {.camera = "cam1"}),
              HasSubstr("a.mcap: --camera = cam1, expected one of /camera/camera_info, /wide/camera_info"));
  for (const auto& [model, coefficient, sentence] :
       {std::tuple{"fov", 0.1, "a.mcap: /c: distortion_model = fov, expected plumb_bob"},
        std::tuple{"equidistant", std::nan(""), "a.mcap: /c:1: distortion_coefficients[0] = nan, expected"},
        std::tuple{"a\nb", 0.1, "distortion_model = a\\nb, expected"}}) {
    test::BagWriter one;
    one.add("/c", "sensor_msgs/msg/CameraInfo", 0.0, test::camera_info(model, {coefficient, 0, 0, 0}));
    EXPECT_THAT(refused(bag(one)), HasSubstr(sentence));
  }
  EXPECT_THAT(refused(bag(test::BagWriter())),
              HasSubstr("a.mcap: no sensor_msgs/CameraInfo, expected a bag with"));
  std::ofstream(folder / "a.ulg", std::ios::binary) << "ULog\x01\x12\x35";
  EXPECT_THAT(refused({folder / "a.ulg"}),
              HasSubstr("a.ulg:1: this is a PX4 ULog, expected a crazyflies.yaml"));
}

TEST(ImportCamera, AChainOfKalibrGivesTheCameraThatIsChosen) {
  const Imported first = imported(chain);
  const Camera fisheye = camera_of(first);
  EXPECT_EQ(fisheye.width, 512);
  EXPECT_EQ(fisheye.distortion, Distortion::equidistant);
  EXPECT_THAT(fisheye.coefficients, ElementsAre(-0.013, 0.021, -0.012, 0.002));
  EXPECT_THAT(first.notes, ElementsAre("cam1 is left out, --camera chooses it"));
  const Camera second = camera_of(imported(chain, {.camera = "cam1"}));
  EXPECT_EQ(second.distortion, Distortion::plumb_bob);
  EXPECT_THAT(second.focal_length, ElementsAre(458.6, 457.2));
  EXPECT_THAT(imported(chain, {.agent = "eye"}).text, HasSubstr("[agent.eye.camera]"));
}

TEST(ImportCamera, RefusesWithPlaceKeyValueAndWhatWasExpected) {
  EXPECT_EQ(
      refusal(with(chain, "pinhole", "omni")),
      "lab/a.yaml:3: cam0.camera_model = omni, expected pinhole: calibrate with pinhole-equi, which has wide "
      "angles too");
  EXPECT_EQ(refusal(chain, {.camera = "cam7"}), "lab/a.yaml: --camera = cam7, expected one of cam0, cam1");
  EXPECT_THAT(refusal(with(ros_camera, "-0.0011, 0.0]", "-0.0011]\n")), testing::IsEmpty())
      << "4 of plumb_bob do";
  EXPECT_THAT(
      refusal(with(ros_camera, "[-0.28, 0.07, ", "[")),
      HasSubstr("expected those of its distortion (camera.coefficients has 3 numbers, expected 4 or 5"));
  EXPECT_THAT(refusal(with(ros_camera, "301.5, 0,", "301.5, 2,")), HasSubstr("pixels without skew"));
  EXPECT_THAT(refusal(with(ros_camera, "301.5", "-301.5")), HasSubstr("focal lengths of 1 to 1e5 px"));
  EXPECT_THAT(
      refusal(with(ros_camera, "plumb_bob", "thin_prism")),
      HasSubstr("distortion_model = thin_prism, expected plumb_bob, rational_polynomial or equidistant"));
  EXPECT_THAT(refusal(with(ros_camera, "640", "64000")),
              HasSubstr("image_width = 64000, expected an integer"));
  EXPECT_THAT(refusal(ros_camera, {.agent = "a]b"}), HasSubstr("--agent"));
}

const std::string node_tags = R"(apriltag:
  ros__parameters:
    family: 36h11
    size: 0.173
    tag:
      ids: [9, 14]
      frames: [cart_left, "cart:right"]
      sizes: [0.162, 0.162]
)";
const std::string slam_tags = R"(bodies:
  - rig:
      is_static: false
      default_tag_size: 0.1
      tags:
        - id: 3
        - id: 4
          pose: { position: { x: 0.1, y: 0, z: 0 } }
  - wall:
      is_static: true
)";

/// The scenario of tags, with the bodies that their tables lack.
Scenario tagged(const Imported& made) {
  std::string text = "[agent.uav0]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n" + made.text;
  int x = 2;
  for (std::size_t at = text.find("[target."); at != std::string::npos; at = text.find("[target.", at + 1)) {
    const std::string name = text.substr(at + 8, text.find(".tags]", at) - at - 8);
    const std::string body = fmt::format("[target.{}]\np = [{}, 0, 1]\n", name, x++);
    text.insert(at, body);
    at += body.size();
  }
  return scenario_of(text);
}

TEST(ImportTags, EachTagIsATargetOrAFaceOfOneRobot) {
  const Scenario targets = tagged(imported(node_tags));
  ASSERT_EQ(targets.vision.tags.size(), 2U);
  EXPECT_EQ(targets.team.name(targets.vision.tags[1].body), "cart_right");
  EXPECT_EQ(targets.vision.tags[1].tags.size, 0.162);
  EXPECT_EQ(targets.vision.tags[1].tags.faces, 1);
  EXPECT_EQ(targets.vision.tags[1].tags.distance, 0.0);
  EXPECT_THAT(targets.vision.tag_frames[1], ElementsAre("cart:right"));
  const Scenario robot = tagged(imported(node_tags, {.agent = "uav0"}));
  ASSERT_EQ(robot.vision.tags.size(), 1U);
  EXPECT_EQ(robot.vision.tags[0].tags.faces, 2);
  EXPECT_THAT(robot.vision.tag_frames[0], ElementsAre("cart_left", "cart:right"));
  // Without frames and sizes, those of the node.
  const Scenario plain =
      tagged(imported(with(with(node_tags, "      frames: [cart_left, \"cart:right\"]\n", ""),
                           "      sizes: [0.162, 0.162]\n", "")));
  EXPECT_THAT(plain.vision.tag_frames[1], ElementsAre("tag36h11:14"));
  EXPECT_EQ(plain.vision.tags[1].tags.size, 0.173);
  const Scenario first =
      tagged(imported("standalone_tags:\n  [ {id: 1, size: 0.1, name: cart}, {id: 2, size: 0.2} ]\n"));
  EXPECT_EQ(first.vision.tags[1].tags.size, 0.2);
  EXPECT_EQ(first.team.name(first.vision.tags[0].body), "cart");
}

TEST(ImportTags, ABodyOfTagSlamHasItsTagsAsFaces) {
  const Imported made = imported(slam_tags);
  const Scenario read = tagged(made);
  ASSERT_EQ(read.vision.tags.size(), 1U);
  EXPECT_EQ(read.team.name(read.vision.tags[0].body), "rig");
  EXPECT_EQ(read.vision.tags[0].tags.size, 0.1);
  EXPECT_THAT(read.vision.tag_frames[0], ElementsAre("tag36h11:3", "tag36h11:4"));
  EXPECT_THAT(made.notes, ElementsAre(HasSubstr("bodies[0].rig.tags[1].pose has no counterpart"),
                                      "wall has no tags, left out"));
}

TEST(ImportTags, RefusesWithPlaceKeyValueAndWhatWasExpected) {
  EXPECT_THAT(refusal(with(node_tags, "36h11", "25h9")),
              StartsWith("lab/a.yaml:3: apriltag.ros__parameters.family = 25h9, expected tag36h11"));
  EXPECT_THAT(refusal(with(node_tags, "[0.162, 0.162]", "[0.162]")), HasSubstr("one for each of the 2 ids"));
  EXPECT_THAT(refusal(with(node_tags, "[9, 14]", "[9, 1400]")), HasSubstr("an integer from 0 to 586"));
  EXPECT_THAT(refusal(with(node_tags, "\"cart:right\"", "cart_left")), HasSubstr("cart_left"));
  EXPECT_THAT(refusal(with(node_tags, "[0.162, 0.162]", "[0.162, 0.1]"), {.agent = "uav0"}),
              HasSubstr("tags of one size"));
  EXPECT_THAT(refusal(with(slam_tags, "      default_tag_size: 0.1\n", "")),
              HasSubstr("bodies[0].rig.tags[0].size is missing"));
}

std::string sdf_rotor(int number, double x, double y) {
  return fmt::format(
      "<link name='rotor_{0}'><pose>{1} {2} 0.06 0 0 "
      "0</pose><inertial><mass>0.016</mass><inertia><ixx>4e-7</ixx>"
      "<iyy>2e-5</iyy><izz>2e-5</izz></inertia></inertial></link>\n"
      "<joint name='joint_{0}' type='revolute'><parent>base</parent><child>rotor_{0}</child></joint>\n",
      number, x, y);
}
std::string sdf_motor(int number, std::string_view turns) {
  return fmt::format(
      "<plugin filename='motor' "
      "name='m{0}'><jointName>joint_{0}</jointName><turningDirection>{1}</turningDirection>"
      "<timeConstantUp>0.0125</timeConstantUp><timeConstantDown>0.025</timeConstantDown>"
      "<maxRotVelocity>1000.0</maxRotVelocity><motorConstant>8.5e-06</motorConstant>"
      "<momentConstant>0.016</momentConstant><rotorDragCoefficient>8e-05</rotorDragCoefficient></plugin>\n",
      number, turns);
}
/// Its base link is turned by a right angle about z, so that its first two moments change places.
const std::string sdf_body =
    "<?xml version='1.0'?>\n<sdf version='1.9'><model name='quad'>\n<link name='base'><inertial>"
    "<pose>0 0 0.01 0 0 1.5707963267948966</pose><mass>2.0</mass><inertia><ixx>0.02</ixx><iyy>0.03</iyy>"
    "<izz>0.04</izz></inertia></inertial></link>\n" +
    sdf_rotor(0, 0.17, -0.17) + sdf_rotor(1, -0.17, 0.17) + sdf_rotor(2, 0.17, 0.17) +
    sdf_rotor(3, -0.17, -0.17);
const std::string sdf_motors =
    sdf_motor(0, "ccw") + sdf_motor(1, "ccw") + sdf_motor(2, "cw") + sdf_motor(3, "cw");
const std::string quad = sdf_body + sdf_motors + "</model></sdf>\n";

Vehicle vehicle_of(const Imported& made) {
  const Scenario read = scenario_of(
      "[world]\nkind = \"rotors\"\n[agent.uav0]\nrobot = \"multirotor\"\nstart = { p = "
      "[0, 0, 1] }\n" +
      made.text);
  return read.vehicles.at(0).vehicle;
}

TEST(ImportSdf, TheLinksAreOneBodyAndTheMotorsItsRotors) {
  const Imported made = imported(quad);
  const Vehicle v = vehicle_of(made);
  EXPECT_NEAR(v.mass, 2.064, 1e-12);
  // By the parallel axes, about the common centre.
  const double z = (2.0 * 0.01 + 4 * 0.016 * 0.06) / 2.064, of_rotors = 4 * 0.016;
  const double up = 2.0 * (0.01 - z) * (0.01 - z) + of_rotors * (0.06 - z) * (0.06 - z),
               level = of_rotors * 0.17 * 0.17;
  EXPECT_NEAR(v.inertia.x, 0.03 + 4 * 4e-7 + level + up, 1e-9);
  EXPECT_NEAR(v.inertia.y, 0.02 + 4 * 2e-5 + level + up, 1e-9);
  EXPECT_NEAR(v.inertia.z, 0.04 + 4 * 2e-5 + 2 * level, 1e-9);
  EXPECT_THAT(v.rotor_x, testing::Pointwise(testing::DoubleNear(1e-12), {0.17, -0.17, 0.17, -0.17}));
  EXPECT_THAT(v.rotor_y, testing::Pointwise(testing::DoubleNear(1e-12), {-0.17, 0.17, 0.17, -0.17}));
  EXPECT_THAT(v.spin, ElementsAre(1, 1, -1, -1));
  EXPECT_EQ(v.k_f, 8.5e-6);
  EXPECT_EQ(v.k_m, 0.016);
  EXPECT_EQ(v.speed_max, 1000.0);
  EXPECT_EQ(v.tau_up, 0.0125);
  EXPECT_EQ(v.tau_down, 0.025);
  EXPECT_EQ(v.rotor_drag, 8e-5);
  EXPECT_THAT(made.notes, ElementsAre(HasSubstr("stay those of the preset")));
}

TEST(ImportSdf, MotorsMayBeInAnotherFileThanTheLinks) {
  const std::vector<ImportFile> two = {
      {"x/model.sdf", "<sdf version='1.9'><model name='x'>" + sdf_motors + "</model></sdf>"},
      {"base/model.sdf", sdf_body + "</model></sdf>"}};
  const std::string text = import_texts(two).text, whole = imported(quad).text;
  EXPECT_EQ(text.substr(text.find('\n')), whole.substr(whole.find('\n')));
  EXPECT_THAT(refusal(two[0].text), HasSubstr("expected"));
}

TEST(ImportSdf, RefusesWithPlaceElementTextAndWhatWasExpected) {
  EXPECT_THAT(refusal(with(quad, "<mass>2.0</mass>", "<mass>-2.0</mass>")),
              StartsWith("lab/a.yaml:3: <mass> = -2.0, expected > 0 kg"));
  EXPECT_THAT(refusal(with(quad, "turningDirection>ccw", "turningDirection>up")),
              HasSubstr("<turningDirection> = up, expected cw or ccw"));
  EXPECT_THAT(refusal(with(quad, "joint_0<", "joint_9<")),
              HasSubstr("<plugin> = joint_9, expected a link of these files"));
  EXPECT_THAT(refusal(with(quad, "<mass>2.0</mass>", "<mass>200.0</mass>")), HasSubstr("thrust to weight"));
  EXPECT_THAT(refusal(with(quad, "8.5e-06", "9.5e-06")), HasSubstr("the constants of the first motor"));
  EXPECT_THAT(refusal(with(quad, "0.06 0 0 0<", "0.06 0 0.5 0<")), HasSubstr("thrusts along z"));
  EXPECT_THAT(refusal("<rss/>"), HasSubstr("<rss> = another kind of XML, expected SDF, URDF or MJCF"));
  const std::vector<ImportFile> two = {{"a.sdf", quad}, {"b.urdf", "<robot name='a'/>"}};
  EXPECT_THAT(refusal_of<ScenarioError>([&] { (void)import_texts(two); }),
              HasSubstr("b.urdf:1: <robot> = one more file, expected one URDF or MJCF"));
  EXPECT_THAT(refusal("<sdf><model>"), HasSubstr("cannot be read as XML"));
  for (const char* empty : {"<!-- no model -->\n", "<?xml version='1.0'?>\n"})
    EXPECT_THAT(refusal(empty), HasSubstr("XML without an element"));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<model>";
  EXPECT_THAT(refusal("<sdf>" + deep), HasSubstr("cannot be read as XML"));
}

std::string urdf_link(std::string_view name, std::string_view mass, std::string_view origin) {
  return fmt::format(
      "<link name='{}'><inertial><origin {}/><mass value='{}'/><inertia ixx='4e-5' ixy='0' ixz='0' "
      "iyy='6e-5' iyz='0' izz='8e-5'/></inertial></link>\n",
      name, origin, mass);
}
std::string urdf_joint(std::string_view child, std::string_view origin) {
  return fmt::format(
      "<joint name='{0}_joint' type='fixed'><origin {1}/><parent link='base'/><child link='{0}'/></joint>\n",
      child, origin);
}
/// Two places are in the joints and two in the inertial frames. The battery is turned by a right
/// angle.
const std::string urdf_links =
    "<?xml version='1.0'?>\n<robot name='small'>\n" + urdf_link("base", "0.03", "xyz='0 0 0'") +
    urdf_link("battery", "0.01", "xyz='0 0 0.02'") + urdf_link("prop0_link", "0", "xyz='0.03 -0.03 0'") +
    urdf_link("prop1_link", "0", "xyz='-0.03 -0.03 0'") + urdf_link("prop2_link", "0", "rpy='0 0 0'") +
    urdf_link("prop3_link", "0", "rpy='0 0 0'") +
    urdf_joint("battery", "xyz='0 0 -0.04' rpy='0 0 1.5707963267948966'") +
    urdf_joint("prop0_link", "xyz='0 0 0'") + urdf_joint("prop1_link", "xyz='0 0 0'") +
    urdf_joint("prop2_link", "xyz='-0.03 0.03 0'") + urdf_joint("prop3_link", "xyz='0.03 0.03 0'");
const std::string small =
    with(urdf_links, "<link",
         "<properties arm='0.0424' kf='3e-10' km='6e-12' thrust2weight='2' prop_radius='0.02'/>\n<link") +
    "</robot>\n";

TEST(ImportUrdf, TheLinksAreOneBodyAndThePropertiesItsRotors) {
  const Imported made = imported(small, {.agent = "cf1"});
  EXPECT_THAT(made.text, HasSubstr("[agent.cf1.vehicle]"));
  EXPECT_THAT(made.text, HasSubstr("# Not in the file, so as in the preset, x500 if none is stated: tau_up, "
                                   "tau_down, rotor_drag, radius, height, drag, gains.\n"));
  // The directions of rotation are to be filled in, and nothing is flown without them.
  EXPECT_THAT(made.notes, Contains(HasSubstr("complete spin = []")));
  Imported open = imported(small);
  EXPECT_THAT(refusal_of<ScenarioError>([&] { vehicle_of(open); }), HasSubstr("spin"));
  open.text = with(open.text, "spin = []", "spin = [1, -1, 1, -1]");
  const Vehicle v = vehicle_of(open);
  EXPECT_NEAR(v.mass, 0.04, 1e-15);
  // By hand: the battery hangs 0.02 m below, its first two moments change places.
  const double up = 0.03 * 0.005 * 0.005 + 0.01 * 0.015 * 0.015, links = 4;
  EXPECT_NEAR(v.inertia.x, (links + 1) * 4e-5 + 6e-5 + up, 1e-12);
  EXPECT_NEAR(v.inertia.y, (links + 1) * 6e-5 + 4e-5 + up, 1e-12);
  EXPECT_NEAR(v.inertia.z, (links + 2) * 8e-5, 1e-12);
  EXPECT_THAT(v.rotor_x, testing::Pointwise(testing::DoubleNear(1e-12), {0.03, -0.03, -0.03, 0.03}));
  EXPECT_THAT(v.rotor_y, testing::Pointwise(testing::DoubleNear(1e-12), {-0.03, -0.03, 0.03, 0.03}));
  EXPECT_NEAR(v.thrust_max() / v.weight(), 2.0, 1e-12);
  EXPECT_NEAR(v.k_m, 0.02, 1e-15);
  // The thrust at 1000 revolutions per minute.
  const double speed = 1000 * 2 * std::numbers::pi / 60;
  EXPECT_NEAR(v.k_f * speed * speed, 3e-10 * 1e6, 1e-15);
  EXPECT_EQ(v.rotor_radius, 0.02);
}

TEST(ImportUrdf, OnlyLinksNamedAsPropellersAreRotors) {
  const auto has_rotors = [](std::string_view base, std::string_view link) {
    const std::string made =
        imported("<robot name='a'>" + urdf_link(base, "0.03", "rpy='0 0 0'") +
                 urdf_link(link, "0", "rpy='0 0 0'") +
                 with(urdf_joint(link, "xyz='0.1 0 0'"), "link='base'", fmt::format("link='{}'", base)) +
                 "</robot>")
            .text;
    return made.find("rotor_x = [0.1]") != std::string::npos;
  };
  for (const char* link :
       {"prop0_link", "rotor_0", "front_left_prop", "Propeller", "m1rotor", "my_prop_rotor"})
    EXPECT_TRUE(has_rotors("base", link)) << link;
  for (const char* link : {"quadrotor", "multirotor_arm", "prop_guard", "PropGuard1", "support", "arm"})
    EXPECT_FALSE(has_rotors("base", link)) << link;
  for (const char* base : {"rotorcraft", "quad_rotor", "quadrotor"}) {
    EXPECT_TRUE(has_rotors(base, "rotor_0")) << base;
    EXPECT_FALSE(has_rotors(base, "arm")) << base;
  }
}

TEST(ImportUrdf, MotorsOfGazeboStateTheRotors) {
  std::string motors = "<gazebo>";
  for (int i = 0; i < 4; ++i)
    motors += with(sdf_motor(i, i % 2 == 0 ? "ccw" : "cw"), fmt::format("joint_{}<", i),
                   fmt::format("prop{}_link_joint<", i));
  // Motors are at their links.
  std::string links = urdf_links;
  for (const std::string place : {"xyz='0.03 -0.03 0'", "xyz='-0.03 -0.03 0'"}) {
    links = with(links, place, "xyz='0 0 0.0'");
    links = with(links, "type='fixed'><origin xyz='0 0 0'", fmt::format("type='fixed'><origin {}", place));
  }
  const Imported made = imported(links + motors + "</gazebo></robot>");
  const Vehicle v = vehicle_of(made);
  EXPECT_THAT(v.spin, ElementsAre(1, -1, 1, -1));
  EXPECT_EQ(v.k_f, 8.5e-6);
  EXPECT_EQ(v.tau_down, 0.025);
}

TEST(ImportUrdf, RefusesWithPlaceElementTextAndWhatWasExpected) {
  EXPECT_THAT(refusal(with(small, "kf='3e-10'", "kf='-3e-10'")),
              StartsWith("lab/a.yaml:3: <properties kf> = -3e-10, expected > 0 N/rpm^2"));
  EXPECT_THAT(refusal(with(small, "mass value='0.03'", "mass value='${m}'")),
              HasSubstr("<mass value> = ${m}, expected >= 0 kg"));
  EXPECT_THAT(refusal(with(small, "<link", "<xacro:property name='m' value='1'/><link")),
              HasSubstr("expected URDF, which xacro FILE prints"));
  EXPECT_THAT(refusal(with(small, "child link='battery'", "child link='gone'")),
              HasSubstr("<child> = gone, expected a link of this file"));
  EXPECT_THAT(refusal(with(small, "child link='battery'", "child link='base'")),
              HasSubstr("<robot> = joints in a circle, expected a tree of links and joints"));
  EXPECT_THAT(refusal("<robot name='a'/>"), HasSubstr("1 to 256 links"));
}

/// A child body, a turned site, defaults by class, and shapes of each kind with mass or density.
const std::string carrier = R"(<mujoco model="carrier">
<compiler angle="degree" eulerseq="zyx"/>
<default><geom density="400"/><motor ctrlrange="0 6"/>
<default class="arm"><geom type="capsule" mass="0.05"/><default class="pod"><geom type="ellipsoid" size="0.05 0.04 0.03"/></default></default></default>
<worldbody><geom type="plane" size="9 9 1"/><light pos="0 0 3"/>
<body name="carrier" pos="0 0 1" childclass="arm"><freejoint/>
<geom fromto="0 0 0 0.2 -0.2 0" size="0.01"/><geom fromto="0 0 0 -0.2 0.2 0" size="0.01"/>
<geom fromto="0 0 0 0.2 0.2 0" size="0.01"/><geom fromto="0 0 0 -0.2 -0.2 0" size="0.01"/>
<geom class="main" type="box" size="0.1 0.06 0.03" euler="10 5 20"/>
<site name="s0" pos="0.2 -0.2 0.02"/><site name="s1" pos="-0.2 0.2 0.02" euler="90 0 0"/>
<site name="s2" pos="0.2 0.2 0.02" zaxis="0 0 2"/><site name="s3" pos="-0.2 -0.2 0.02" quat="2 0 0 2"/>
<frame pos="0 0 -0.1"><geom class="pod" euler="30 0 0" pos="0 0 0.01"/></frame>
<body name="leg" pos="0 0 -0.05" axisangle="0 0 1 45"><geom type="cylinder" size="0.02 0.03" density="900" xyaxes="0 1 0 0 0 1"/>
<body name="foot" pos="0 0 -0.05"><inertial pos="0 0 0.01" mass="0.04" fullinertia="2e-5 3e-5 4e-5 1e-6 0 2e-6"/>
<geom type="sphere" size="0.02"/></body></body>
</body></worldbody>
<actuator><motor site="s0" gear="0 0 1 0 0 -0.02"/><motor site="s1" gear="0 0 1 0 0 -0.02"/>
<motor site="s2" gear="0 0 1 0 0 0.02"/><motor site="s3" gear="0 0 1 0 0 0.02"/></actuator>
</mujoco>
)";

TEST(ImportMjcf, MotorsAtSitesAreRotors) {
  const Imported made = imported(carrier);
  const Vehicle v = vehicle_of(made);
  EXPECT_THAT(v.spin, ElementsAre(1, 1, -1, -1))
      << "a rotor that turns anticlockwise turns its body clockwise";
  EXPECT_NEAR(v.rotor_x[0] - v.rotor_x[1], 0.4, 1e-12);
  EXPECT_NEAR(v.rotor_y[0] - v.rotor_y[1], -0.4, 1e-12);
  EXPECT_NEAR(v.thrust_max(), 4 * 6.0, 1e-12);
  EXPECT_EQ(v.k_m, 0.02);
  EXPECT_THAT(made.text, HasSubstr("# The file has thrusts, at most 6 N each, and no speeds of rotors"));
  EXPECT_THAT(made.text,
              HasSubstr("tau_up, tau_down, rotor_drag, rotor_radius, radius, height, drag, gains.\n"));
}

const std::string body_alone =
    "<mujoco><worldbody><body><inertial pos='0 0 0' mass='0.027' diaginertia='2e-5 2e-5 3e-5'/><site "
    "name='a'/></body></worldbody><actuator><motor site='a' gear='0 0 1' ctrlrange='0 0.35'/><motor site='a' "
    "gear='0 0 0 1' name='x_moment'/></actuator></mujoco>";

TEST(ImportMjcf, AFileWithoutRotorsGivesTheBodyAlone) {
  const Imported made = imported(body_alone);
  EXPECT_THAT(made.text,
              HasSubstr("# One thrust of all rotors, at most 0.35 N.\n# Not in the file, so as in the "
                        "preset, x500 if none is stated: rotor_x, rotor_y, spin, k_f, k_m,"));
  EXPECT_THAT(made.text,
              testing::EndsWith("[agent.uav0.vehicle]\nmass = 0.027\ninertia = [2e-05, 2e-05, 3e-05]\n"));
  EXPECT_THAT(made.notes, Contains(HasSubstr("x_moment is a torque without thrust")));
}

TEST(ImportMjcf, OneMoreCompilerChangesWhatItStates) {
  const std::string second = "<compiler eulerseq=\"zyx\"/>\n<default><geom";
  const auto body_of = [](const std::string& text) {
    const std::string made = imported(text).text;
    return made.substr(made.find('\n'));
  };
  for (const char* first :
       {"angle=\"radian\"", "inertiafromgeom=\"true\"", "inertiafromgeom=\"true\" autolimits=\"false\""}) {
    const std::string one = with(carrier, "angle=\"degree\"", first);
    EXPECT_NE(body_of(one), body_of(carrier)) << first;
    EXPECT_EQ(body_of(one), body_of(with(one, "<default><geom", second))) << first;
  }
  const std::string radian = with(carrier, "angle=\"degree\"", "angle=\"radian\" inertiafromgeom=\"true\"");
  EXPECT_EQ(body_of(carrier),
            body_of(with(radian, "<default><geom",
                         "<compiler angle=\"degree\" inertiafromgeom=\"auto\"/>\n<default><geom")));
}

TEST(ImportMjcf, EachIncludeIsNoted) {
  const auto notes = [](std::string_view before) {
    return imported(with(carrier, before, fmt::format("<include file=\"more.xml\"/>{}", before))).notes;
  };
  for (const char* place : {"<geom density", "<geom type=\"capsule\"", "<motor site=\"s0\"",
                            "<geom type=\"plane\"", "<worldbody>", "<body name=\"foot\""})
    EXPECT_THAT(notes(place), Contains("what is in the included more.xml does not count")) << place;
}

TEST(ImportMjcf, RefusesWithPlaceElementTextAndWhatWasExpected) {
  EXPECT_THAT(refusal(with(carrier, "eulerseq=\"zyx\"", "inertiagrouprange=\"0 1\"")),
              HasSubstr("<compiler> = inertiagrouprange, expected masses of all groups of geoms"));
  EXPECT_THAT(refusal(with(carrier, "eulerseq=\"zyx\"", "coordinate=\"global\"")),
              HasSubstr("<compiler> = coordinate, expected poses in the frame of the parent (local)"));
  const std::string as_usual = "eulerseq=\"zyx\" coordinate=\"local\" inertiagrouprange=\"0 5\"";
  EXPECT_EQ(imported(with(carrier, "eulerseq=\"zyx\"", as_usual)).text, imported(carrier).text);
  EXPECT_THAT(refusal(with(carrier, "class=\"pod\" euler", "class=\"gone\" euler")),
              HasSubstr("<geom> = gone, expected a class of <default>"));
  EXPECT_THAT(refusal(with(carrier, "type=\"cylinder\"", "type=\"mesh\" mesh=\"leg\"")),
              HasSubstr("<geom> = mesh, expected a solid sphere, capsule"));
  EXPECT_THAT(refusal(with(carrier, "zaxis=\"0 0 2\"", "zaxis=\"1 0 0\"")), HasSubstr("thrusts along z"));
  EXPECT_THAT(refusal(with(carrier, "gear=\"0 0 1 0 0 0.02\"", "gear=\"0 0 2 0 0 0.02\"")),
              HasSubstr("the gear and range of the first motor"));
  EXPECT_THAT(refusal(with(carrier, "<body name=\"carrier\"",
                           "<body name=\"other\"><freejoint/></body><body name=\"carrier\"")),
              HasSubstr("<mujoco> = 2 bodies, 2 with a free joint, expected one that flies"));
  EXPECT_THAT(refusal(with(carrier, "eulerseq=\"zyx\"", "settotalmass=\"3\"")),
              HasSubstr("expected masses as parts have them"));
  // Equal thrusts of it would leave the yaw without torque.
  EXPECT_THAT(refusal(with(with(carrier, "s1\" gear=\"0 0 1 0 0 -0.02", "s1\" gear=\"0 0 1 0 0 0.02"),
                           "s2\" gear=\"0 0 1 0 0 0.02", "s2\" gear=\"0 0 1 0 0 -0.02")),
              HasSubstr("leave an axis without torque"));
  EXPECT_THAT(refusal("<mujoco/>"), HasSubstr("0 bodies"));
}

TEST(Import, ABodyWithoutSoundInertiaIsRefusedThoughTheFileLacksRotors) {
  for (const char* moments : {"-2e-5 2e-5 3e-5", "2e-5 0 3e-5", "2e-5 2e-5 -3e-5"})
    EXPECT_THAT(refusal(with(body_alone, "2e-5 2e-5 3e-5", moments)),
                HasSubstr("<mujoco> = a model, expected a multirotor that flies (vehicle.inertia = "));
  EXPECT_THAT(refusal(with(body_alone, "0.027", "0")), HasSubstr("no mass"));
  // Of this file the spin alone is missing.
  EXPECT_THAT(refusal(with(small, "ixx='4e-5'", "ixx='-4e-3'")), HasSubstr("vehicle.inertia = -0.00"));
}

TEST(Import, AFileOfAnotherKindIsNamed) {
  EXPECT_THAT(refusal("[agent.a]\n"), StartsWith("lab/a.yaml:1: "));
  EXPECT_THAT(refusal("world: lab\n"), HasSubstr("this is YAML, expected"));
  EXPECT_THAT(refusal(""), HasSubstr("expected"));
  const std::vector<ImportFile> three = {{"a", swarm}, {"b", server}, {"c", server}};
  EXPECT_THAT(refusal_of<ScenarioError>([&] { (void)import_texts(three); }),
              HasSubstr("at most its server.yaml"));
  const std::filesystem::path folder = test::fresh_folder();
  const std::vector<std::filesystem::path> none = {folder / "gone.yaml"};
  EXPECT_THAT(refusal_of<ScenarioError>([&] { (void)import_files(none); }), HasSubstr("cannot be read"));
  const std::vector<std::filesystem::path> large = {folder / "large.yaml"};
  std::ofstream(large[0]) << "a: " << std::string(2'000'000, 'b');
  EXPECT_THAT(refusal_of<ScenarioError>([&] { (void)import_files(large); }), HasSubstr("too large"));
}

TEST(ImportCamera, AMatrixThatNamesItselfIsRefused) {
  for (const char* key : {"camera_matrix", "distortion_coefficients"})
    EXPECT_THAT(refusal("image_width: 640\nimage_height: 480\n" + std::string(key) + ": &m {data: *m}\n"),
                HasSubstr("expected"));
}

TEST(ImportSdf, APartThatIsIncludedIsNoted) {
  const Imported made = imported(
      with(quad, "<joint", "<include><uri>model://pod</uri><pose>0 0 1 0 0 0</pose></include><joint"));
  EXPECT_THAT(made.notes,
              testing::Contains(HasSubstr("model://pod count if its file is given, and at the origin")));
}

TEST(Import, NestingIsBounded) {
  for (const std::string& deep : {std::string(100'000, '['), "a: " + std::string(100'000, '{'), [] {
                                    std::string text;
                                    for (int i = 0; i < 100'000; ++i) text += "- ";
                                    return text + "1\n";
                                  }()})
    EXPECT_THAT(refusal(deep), HasSubstr("nested deeper than 64 levels"));
  std::string blocks;
  for (int i = 0; i < 900; ++i) blocks += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_FALSE(refusal(blocks).empty());
  std::string laughs = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 30; ++i)
    laughs += fmt::format("a{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
  EXPECT_FALSE(refusal(laughs).empty());
  EXPECT_THAT(refusal("a: []0.1, 2]\nb: 3\n"), HasSubstr("YAML")) << "a bracket that is closed twice";
  EXPECT_THAT(refusal("a: 1\n---\nb: 2\n"), HasSubstr("this is not one YAML document"));
}

/// Changes bytes and signs, and doubles, removes or swaps parts.
std::string mutated(std::string text, Random& random) {
  const auto place = [&] { return static_cast<std::size_t>(random() % (text.size() + 1)); };
  constexpr std::string_view marks = ":-[]{}&*!|>'\"%#,\n \t?~0123456789eE.+";
  const int changes = 1 + static_cast<int>(random() % 4);
  for (int i = 0; i < changes && !text.empty(); ++i) {
    const std::size_t at = place(), length = std::min<std::size_t>(random() % 24, text.size() - at);
    switch (random() % 6) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(random());
        break;
      case 1:
        text.insert(at, 1, marks[random() % marks.size()]);
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(place() % (text.size() + 1), text.substr(at, length));
        break;
      case 4:
        text.insert(std::min(text.find_first_of("0123456789", at), text.size()), 1, '-');
        break;
      default:
        if (at < text.size()) text[at] = marks[random() % marks.size()];
    }
  }
  return text;
}

// What is accepted is read by our own reader, all else is refused by one line.
TEST(Import, MutatedFilesAreReadOrRefused) {
  Random random(11);
  const int inputs = runs(9 * 100'000, 150);
  int accepted = 0;
  for (int k = 0; k < inputs; ++k) {
    const std::array all = {swarm, ros_camera, chain, node_tags, quad, slam_tags, small, carrier, body_alone};
    const std::string text = mutated(all[static_cast<std::size_t>(k) % all.size()], random);
    Imported made;
    try {
      made = imported(text);
    } catch (const ScenarioError& error) {
      ASSERT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
      ASSERT_THAT(error.what(), StartsWith("lab/a.yaml"));
      continue;
    }
    ++accepted;
    if (made.text.find("[fleet]") != std::string::npos) {
      ASSERT_NO_THROW(scenario_of(made.text)) << text << made.text;
    } else if (made.text.find(".vehicle]") != std::string::npos) {
      // A file that lacks numbers is completed by hand, but has a body.
      std::array<double, 4> body{};
      ASSERT_EQ(
          std::sscanf(made.text.c_str() + made.text.find("\nmass = "),
                      "\nmass = %lf\ninertia = [%lf, %lf, %lf]", &body[0], &body[1], &body[2], &body[3]),
          4)
          << made.text;
      for (const double number : body) ASSERT_TRUE(std::isfinite(number) && number > 0) << text << made.text;
      const bool whole = made.text.find("spin = [1.0, ") != std::string::npos;
      ASSERT_TRUE(!whole || made.text.find("\nk_f = ") == std::string::npos || vehicle_of(made).mass > 0)
          << text;
    } else if (made.text.find(".tags]") != std::string::npos) {
      ASSERT_NO_THROW(tagged(made)) << text << made.text;
    } else {
      ASSERT_NO_THROW(camera_of(made)) << text << made.text;
    }
  }
  EXPECT_GT(accepted, 400);
  EXPECT_LT(accepted, inputs / 12 * 11);
}

}  // namespace
}  // namespace sightline
