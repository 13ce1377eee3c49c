#include "sightline/scenario/read_camera.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/judge/summary.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "sightline/sensors.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/command.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::scenario_of;
using test::scenario_refusal;
using testing::AllOf;
using testing::HasSubstr;

const std::string facing_pair = R"toml([agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }

[agent.a.sensor]
pitch = 0.2
offset = 0.1

[agent.b]
robot = "multirotor"
start = { p = [1.5, 0.0, 0.8], heading = 0.5 }

[obstacle.pillar]
p = [4.0, 0.0, 1.0]

[[couple]]
potential = { too_near = { d_min = 1.0 } }
between = ["a", "b"]
felt_by = ["a"]

[[couple]]
potential = { too_far = { d_max = 2.0 } }
between = ["a", "b"]
felt_by = ["a"]
)toml";

TEST(ReadCamera, CamerasAndTagsHaveTheNamesThatTfCallsThemBy) {
  const std::string tagged =
      "[agent.a.camera]\n%[agent.b.tags]\nfaces = 2\n$[obstacle.pillar.tags]\nfaces = 1\n";
  const auto with = [&](const std::string& camera, const std::string& tags) {
    std::string text = facing_pair + tagged;
    text.replace(text.find('%'), 1, camera);
    text.replace(text.find('$'), 1, tags);
    return text;
  };
  const Scenario plain = scenario_of(with("", ""));
  EXPECT_EQ(plain.vision.cameras[0].frame, "a_camera_optical_frame");
  const std::vector<std::vector<std::string>> numbered = {{"tag36h11:0", "tag36h11:1"}, {"tag36h11:2"}};
  EXPECT_EQ(plain.vision.tag_frames, numbered);
  const Scenario named = scenario_of(with("optical_frame = \"cam\"\n", "frames = [\"front\", \"back\"]\n"));
  EXPECT_EQ(named.vision.cameras[0].frame, "cam");
  EXPECT_EQ(named.vision.tag_frames[0][1], "back");
  EXPECT_THAT(scenario_refusal(with("optical_frame = \"\"\n", "")),
              HasSubstr("agent.a.camera.optical_frame"));
  EXPECT_THAT(scenario_refusal(with("", "frames = [\"front\", \"front\"]\n")),
              HasSubstr("agent.b.tags.frames"));
  EXPECT_THAT(scenario_refusal(with("", "frames = [\"front\"]\n")), HasSubstr("agent.b.tags.frames"));
}

TEST(ReadCamera, ACameraOfANamedSensorHasAFrameOfItsOwnAndIsCalledByIt) {
  const auto with = [&](const std::string& rest) {
    return facing_pair + "[agent.a.sensors.left]\ncamera = { correlation_time = 0.5 }\n" + rest;
  };
  const Scenario alone = scenario_of(with(""));
  ASSERT_EQ(alone.vision.cameras.size(), 1U);
  EXPECT_EQ(alone.vision.cameras[0].camera.correlation_time, 0.5) << "one camera may have it";
  EXPECT_EQ(alone.vision.cameras[0].frame, "a_left_camera_optical_frame");
  EXPECT_EQ(camera_name(alone.vision.cameras[0], alone.team), "a left");
  const Scenario two = scenario_of(facing_pair + "[agent.a.camera]\n[agent.a.sensors.left.camera]\n");
  EXPECT_THAT(camera_words(two),
              AllOf(HasSubstr("camera      a: 320"), HasSubstr("camera      a left: 320")));
  EXPECT_THAT(scenario_refusal(facing_pair + "[agent.a.sensors.\"le ft\".camera]\n"),
              HasSubstr("optical_frame is missing, expected a frame of its own on /tf, of 1 to 128 bytes, "
                        "\"a_le ft_camera_optical_frame\" is none"));
  constexpr std::string_view another =
      "[agent.a_left]\nrobot = \"multirotor\"\nstart = { p = [5.0, 0.0, 1.0], heading = 0.0 }\n"
      "sensor = {}\n";
  EXPECT_THAT(scenario_refusal(with(fmt::format("{}camera = {{}}\n", another))),
              HasSubstr("agent.a_left.camera.optical_frame is missing"));
  EXPECT_EQ(scenario_of(with(fmt::format("{}camera = {{ optical_frame = \"cam\" }}\n", another)))
                .vision.cameras.size(),
            2U);
}

TEST(ReadCamera, ACameraSeesTagsFromTheMountOfItsSensor) {
  const Scenario scenario = scenario_of(facing_pair +
                                        "[agent.a.camera]\nrate = 20.0\nlatency = [0.01, 0.02]\n"
                                        "[agent.b.tags]\nsize = 0.1\nfaces = 6\n"
                                        "[obstacle.pillar.hull]\nradius = 0.3\nheight = 2.0\n"
                                        "[obstacle.pillar.tags]\n");
  ASSERT_EQ(scenario.vision.cameras.size(), 1U);
  const RobotCamera& camera = scenario.vision.cameras[0];
  EXPECT_EQ(camera.observer, scenario.team.find("a"));
  EXPECT_EQ(camera.mount.pitch, 0.2);
  EXPECT_EQ(camera.camera.rate, 20.0);
  EXPECT_EQ(camera.camera.latency[1], 0.02);
  EXPECT_FALSE(camera.render);
  ASSERT_EQ(scenario.vision.tags.size(), 2U);
  EXPECT_EQ(scenario.vision.tags[0].body, scenario.team.find("b"));
  EXPECT_EQ(scenario.vision.tags[0].tags.faces, 6);
  EXPECT_EQ(scenario.vision.tags[1].body, scenario.team.find("pillar"));
  ASSERT_EQ(scenario.vision.hulls.size(), 1U);
  EXPECT_EQ(scenario.vision.hulls[0].hull.height, 2.0);
  const auto world = make_world(scenario);
  EXPECT_NE(dynamic_cast<const CameraWorld*>(world.get()), nullptr);
  EXPECT_GT(world->measured_max().detections, 0U);
}

TEST(ReadCamera, ALensIsReadAndTold) {
  const std::string lens =
      "[agent.a.camera]\nfocal_length = [300.0, 310.0]\nprincipal_point = [150.0, 125.0]\n"
      "distortion = \"equidistant\"\ncoefficients = [0.0, 0.0, 0.0, 0.0]\n";
  const Scenario scenario = scenario_of(facing_pair + lens);
  const Camera& camera = scenario.vision.cameras.at(0).camera;
  EXPECT_EQ(camera.focal(), 310.0);
  EXPECT_EQ(camera.distortion, Distortion::equidistant);
  EXPECT_THAT(summary(scenario), HasSubstr("focal length 310.0 px, equidistant to 3.14 rad, 30 Hz"));
  EXPECT_THAT(scenario_refusal(facing_pair + lens + "field_of_view = 1.0\n"),
              HasSubstr("agent.a.camera.field_of_view = 1, expected no such key beside focal_length"));
  EXPECT_THAT(scenario_refusal(facing_pair + lens.substr(0, lens.find("coeff"))),
              HasSubstr("coefficients has 0 numbers, expected 4 with equidistant"));
}

TEST(ReadCamera, ThePixelsOfATagAreToldAtTheDistancesThatAreKept) {
  const std::string text = facing_pair + "[agent.a.camera]\n[agent.b.tags]\n";
  const Scenario scenario = scenario_of(text);
  const std::vector<TagReading> readings = tag_readings(scenario);
  ASSERT_EQ(readings.size(), 2U);
  EXPECT_EQ(readings[0].key, "d_min");
  EXPECT_NEAR(readings[0].pixels, 41.6, 0.1);
  EXPECT_NEAR(readings[1].pixels, 20.8, 0.1);
  EXPECT_NEAR(readings[1].from_ahead, 10.6, 1e-12);
  EXPECT_NEAR(readings[1].from_any_side, 14.355, 0.01)
      << "of 4 faces the nearest is turned by up to 45 degrees";
  const std::string description = summary(scenario);
  EXPECT_THAT(description,
              HasSubstr("camera      a: 320 x 240 px, focal length 207.8 px, 30 Hz, latency 0.03 to 0.08 s, "
                        "detections drawn by their noise\n"));
  EXPECT_THAT(description, HasSubstr("tags        b: 4 faces of tag36h11, 0.2 m\n"));
  EXPECT_THAT(description, HasSubstr("pixels      a sees a tag of b with 20.8 px at d_max = 2 m\n"));
  // Every second picture of a tag of so many pixels is found.
  EXPECT_NEAR(SyntheticDetections::probability(readings[1].from_ahead, 1.0, 0.0), 0.495, 1e-12);
}

/// A distance that is kept by what one sensor sees.
struct TooNearInView : TooNear {
  SensorMount mount{};
};

TEST(ReadCamera, EachCameraThatSeesATargetHasItsPixels) {
  std::string text = facing_pair + "[agent.b.tags]\n[simulation]\nduration = 0.2\n";
  const std::string sensor = "[agent.a.sensor]\npitch = 0.2\noffset = 0.1\n";
  text.replace(text.find(sensor), sensor.size(),
               "[agent.a.sensors.left]\npitch = 0.2\n[agent.a.sensors.left.camera]\n[agent.a.sensors.far]\n"
               "pitch = 0.1\n[agent.a.sensors.far.camera]\nfield_of_view = 0.5\n");
  for (const char* name : {"left", "far"})
    text += fmt::format(
        "[[couple]]\npotential = {{ bearing = {{ alpha = 0.2 }} }}\nbetween = [\"a\", \"b\"]\nsensor = "
        "\"{}\"\n",
        name);
  const Scenario scenario = scenario_of(text);
  const std::vector<TagReading> readings = tag_readings(scenario);
  ASSERT_EQ(readings.size(), 4U);
  EXPECT_EQ(readings[0].distance, readings[1].distance);
  EXPECT_LT(2 * readings[0].pixels, readings[1].pixels);
  const std::string description = summary(scenario);
  for (const char* name : {"left", "far"})
    EXPECT_THAT(description, HasSubstr(fmt::format("pixels      a {} sees a tag of b with ", name)));
  // A coupling with a sensor of its own gives no reading of the other one.
  ScenarioSpec looking = scenario;
  TooNearInView far;
  far.d_min = 5.0, far.mount.pitch = 0.1;
  looking.team.couple(1.0 * far, scenario.team.couplings()[0].between, {AgentId{0}});
  const std::vector<TagReading> more = tag_readings(looking);
  ASSERT_EQ(more.size(), 5U);
  EXPECT_EQ(more[4].distance, 5.0);
  EXPECT_EQ(more[4].camera->sensor, "far");
  Summary flown(scenario, 1);
  for (const Sample& sample : test::samples_of(scenario)) flown.add(sample);
  std::string lines;
  for (const SummaryLine& line : summary_lines(flown.json())) lines += line.what + "\n";
  EXPECT_THAT(lines, AllOf(HasSubstr("a left sees b\n"), HasSubstr("a far sees b\n")));
}

TEST(ReadCamera, AVehicleHidesWhatIsBehindItAsItsCylinder) {
  const Scenario scenario = scenario_of("[world]\nkind = \"rotors\"\n" + facing_pair +
                                        "[agent.a.camera]\n[agent.b.tags]\n[agent.b.hull]\nradius = 0.1\n");
  const CameraOptions options = camera_options(scenario);
  ASSERT_EQ(options.hulls.size(), 2U);
  EXPECT_EQ(options.hulls[0].body, scenario.team.find("b"));
  EXPECT_EQ(options.hulls[0].hull.radius, 0.1) << "what is said of one holds";
  EXPECT_EQ(options.hulls[1].hull.radius, Vehicle::x500().radius);
  EXPECT_EQ(options.hulls[1].hull.height, Vehicle::x500().height);
}

TEST(ReadCamera, RendersOnlyInAWorldThatCan) {
  const std::string text = facing_pair + "[agent.b.tags]\n[agent.a.camera]\nrender = true\n";
  EXPECT_THAT(
      scenario_refusal(text),
      HasSubstr("agent.a.camera.render = true, expected false in the world \"model\": no world here renders "
                "pictures"));
  Registry registry;
  const auto make = [&registry](const Scenario& scenario) {
    return registry.worlds.find("model")->make(scenario);
  };
  registry.worlds.add("shown", make, MovedBy::models, {}, [](const Scenario& scenario) {
    return std::make_unique<SyntheticDetections>(scenario.team, camera_options(scenario));
  });
  const Scenario scenario = parse_scenario("[world]\nkind = \"shown\"\n" + text, "a.toml", registry);
  EXPECT_TRUE(scenario.vision.cameras[0].render);
  EXPECT_GT(make_world(scenario)->measured_max().detections, 0U);
  EXPECT_EQ(
      refusal_of<ScenarioError>([&] { parse_scenario(text, "a.toml", registry); }),
      "a.toml:27: agent.a.camera.render = true, expected false in the world \"model\", only world.kind = "
      "\"shown\" renders pictures");
}

}  // namespace
}  // namespace sightline
