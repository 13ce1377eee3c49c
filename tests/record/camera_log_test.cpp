#include "sightline/record/camera_log.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <span>

#include "tests/support/folder.hpp"
#include "tests/support/keeping_sink.hpp"

namespace sightline {
namespace {

TEST(CameraLog, ACameraIsReadBackAndAMessageWithoutItsNumbersIsNone) {
  const Camera camera{.width = 640, .height = 480, .field_of_view = 0.9};
  std::vector<std::byte> bytes;
  encode_camera_info(bytes, "uav0_camera_optical_frame", 1'500'000'000, camera);
  const auto read = decode_camera_info(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->width, 640);
  EXPECT_EQ(read->height, 480);
  EXPECT_NEAR(read->focal(), camera.focal(), 1e-9);
  EXPECT_NEAR(camera.focal(), 240 / std::tan(0.45), 1e-9);
  constexpr std::size_t numbers_end = 4 + 40 + 4 + 48 + 9 * 8;
  for (std::size_t size = 0; size < numbers_end; ++size)
    EXPECT_FALSE(decode_camera_info(std::span(bytes).first(size))) << size;
}

TEST(CameraLog, ALensIsReadBack) {
  for (const Camera& camera : {Camera{.focal_length = {300.0, 310.0}, .principal_point = {150.0, 125.0}},
                               Camera{.focal_length = {300.0, 300.0},
                               .distortion = Distortion::plumb_bob,
                               .coefficients = {-0.2, 0.1, 0, 0.01, 0}},
                               Camera{.focal_length = {300.0, 310.0},
                               .distortion = Distortion::rational_polynomial,
                               .coefficients = {1, 2, 3, 4, 5, 6, 7, 8}},
                               Camera{.focal_length = {300.0, 310.0},
                               .distortion = Distortion::equidistant,
                               .coefficients = {0, 0, 0, 0}}}) {
    std::vector<std::byte> bytes;
    encode_camera_info(bytes, "cam", 0, camera);
    const auto read = decode_camera_info(bytes);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->focal_length, camera.focal_length);
    EXPECT_EQ(read->principal_point, camera.principal_point);
    EXPECT_EQ(read->distortion, camera.distortion);
    EXPECT_EQ(read->coefficients, camera.coefficients);
  }
}

// The layout of ROS 2: a header with a frame of 3 letters, then the numbers of the pinhole on
// multiples of 8.
TEST(CameraLog, TheNumbersStandWhereRosHasThem) {
  const Camera camera{};
  std::vector<std::byte> bytes;
  encode_camera_info(bytes, "cam", 0, camera);
  const auto number_at = [&](std::size_t place) {
    double value = 0.0;
    std::memcpy(&value, bytes.data() + 4 + place, sizeof(value));
    return value;
  };
  // stamp 8, frame 4 + 4, height 4, width 4, model 4 + 10, to 40: length 4, to 48: five of
  // distortion.
  constexpr std::size_t k = 48 + 40;
  EXPECT_EQ(number_at(k), camera.focal());
  EXPECT_EQ(number_at(k + 16), 160.0);
  EXPECT_EQ(number_at(k + 40), 120.0);
  EXPECT_EQ(number_at(k + 64), 1.0);
  EXPECT_EQ(bytes.size(), 4 + k + (9 + 9 + 12) * 8 + 6 * 4 + 1);
}

TEST(CameraLog, EachCameraIsSaidOnceInItsOpticalFrame) {
  const Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/localize.toml");
  const test::Folder folder("camera_log_test");
  const std::filesystem::path file = folder.path() / "log.mcap";
  {
    McapWriter mcap(file, "ros2", "test");
    CameraLog log(scenario, mcap);
    for (const double time : {0.0, 0.01, 0.02}) log.add(time);
  }
  int messages = 0;
  McapReader reader(file.string());
  reader.visit([&](const McapMessage& message) {
    ++messages;
    EXPECT_EQ(message.topic, "/uav0/camera_info");
    const auto camera = decode_camera_info(message.bytes);
    ASSERT_TRUE(camera);
    EXPECT_NEAR(camera->focal(), scenario.vision.cameras.at(0).camera.focal(), 1e-9);
  });
  EXPECT_EQ(messages, 1);
}

TEST(CameraLog, EachFurtherCameraOfARobotIsSaidOnATopicOfItsSensor) {
  Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/two_cameras.toml");
  scenario.vision.cameras.at(1).camera.width = 640;
  test::KeepingSink sink;
  CameraLog log(scenario, sink);
  log.add(0.0);
  ASSERT_EQ(sink.messages.size(), 2U);
  EXPECT_EQ(sink.messages[0].topic, "/uav0/camera_info");
  EXPECT_EQ(sink.messages[1].topic, "/uav0/right/camera_info");
  for (std::size_t i = 0; i < 2; ++i) {
    const auto read = decode_camera_info(std::as_bytes(std::span(sink.messages[i].bytes)));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->width, i == 0 ? 320 : 640);
  }
}

}  // namespace
}  // namespace sightline
