#include "sightline/record/camera_log.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "sightline/log.hpp"
#include "sightline/record/log_table.hpp"

namespace sightline {
namespace {

constexpr std::string_view camera_info_text =
    R"(std_msgs/Header header
uint32 height
uint32 width
string distortion_model
float64[] d
float64[9] k
float64[9] r
float64[12] p
uint32 binning_x
uint32 binning_y
sensor_msgs/RegionOfInterest roi
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: sensor_msgs/RegionOfInterest
uint32 x_offset
uint32 y_offset
uint32 height
uint32 width
bool do_rectify
)";
constexpr std::uint64_t second_in_ns = 1'000'000'000;
constexpr std::uint32_t plumb_bob_numbers = 5;

}  // namespace

std::array<double, 9> intrinsics(const Camera& camera) {
  const double f = camera.focal();
  return {f, 0.0, 0.5 * camera.width, 0.0, f, 0.5 * camera.height, 0.0, 0.0, 1.0};
}

RosSchema camera_info_schema() { return {"sensor_msgs/msg/CameraInfo", std::string(camera_info_text)}; }

void encode_camera_info(std::vector<std::byte>& bytes, std::string_view frame, std::uint64_t time,
                        const Camera& camera) {
  const std::array<double, 9> K = intrinsics(camera);
  CdrEncoder to(bytes);
  to.put(static_cast<std::int32_t>(time / second_in_ns)).put(static_cast<std::uint32_t>(time % second_in_ns));
  to.put(frame);
  to.put(static_cast<std::uint32_t>(camera.height)).put(static_cast<std::uint32_t>(camera.width));
  to.put(std::string_view("plumb_bob")).put(plumb_bob_numbers);
  for (std::uint32_t i = 0; i < plumb_bob_numbers; ++i) to.put(0.0);
  for (const double k : K) to.put(k);
  for (int i = 0; i < 9; ++i) to.put(i % 4 == 0 ? 1.0 : 0.0);
  for (std::size_t i = 0; i < 12; ++i) to.put(i % 4 == 3 ? 0.0 : K[3 * (i / 4) + i % 4]);
  for (int i = 0; i < 6; ++i) to.put(std::uint32_t{0});  // no binning, no region
  to.put(std::uint8_t{0});
}

std::optional<Camera> decode_camera_info(std::span<const std::byte> bytes) {
  CdrDecoder from(bytes);
  (void)from.number<std::int32_t>();
  (void)from.number<std::uint32_t>();
  (void)from.string();
  Camera camera;
  const auto height = from.number<std::uint32_t>(), width = from.number<std::uint32_t>();
  (void)from.string();
  const std::size_t distortion = from.length(sizeof(double));
  for (std::size_t i = 0; i < distortion; ++i) (void)from.number<double>();
  std::array<double, 9> k{};
  for (double& number : k) number = from.number<double>();
  constexpr std::uint32_t side_max = 1U << 16U;
  if (!from.ok() || !(k[0] > 0) || !std::isfinite(k[0]) || height > side_max || width > side_max)
    return std::nullopt;
  camera.height = static_cast<int>(height);
  camera.width = static_cast<int>(width);
  camera.field_of_view = 2 * std::atan(0.5 * height / k[0]);
  return camera;
}

CameraLog::CameraLog(const Scenario& scenario, MessageSink& to) : cameras_(scenario.vision.cameras), to_(to) {
  if (cameras_.empty()) return;
  constexpr LogTopic topic = log_topic("/OBSERVER/camera_info");
  const SchemaId schema = topic.add_schema(to, camera_info_schema().text);
  for (const RobotCamera& one : cameras_)
    channels_.push_back(topic.open(to, schema, scenario.team.name(one.observer)));
}

void CameraLog::add(double time) {
  if (reported_) return;
  reported_ = true;
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    encode_camera_info(bytes, cameras_[i].frame, nanoseconds(time), cameras_[i].camera);
    to_.message(channels_[i].id, channels_[i].sequence++, nanoseconds(time), bytes);
  }
}

}  // namespace sightline
