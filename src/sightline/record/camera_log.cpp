#include "sightline/record/camera_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

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
constexpr std::size_t plumb_bob_numbers = 5;
constexpr std::size_t stated_coefficients_max = 8;

/// Whether a model of ROS is one of ours; sets it, with its coefficients, unless all are zero.
bool set_distortion(Camera& camera, std::string_view model, const std::vector<double>& coefficients) {
  const auto word = std::find(distortions.begin() + 1, distortions.end(), model);
  if (word == distortions.end()) return false;
  const auto is = static_cast<Distortion>(word - distortions.begin());
  const bool none = std::all_of(coefficients.begin(), coefficients.end(), [](double c) { return c == 0; });
  if (none && is != Distortion::equidistant) return true;
  camera.distortion = is;
  camera.coefficients = coefficients;
  return true;
}

}  // namespace

std::string_view distortion_model(const Camera& camera) {
  const Distortion model = camera.distortion == Distortion::none ? Distortion::plumb_bob : camera.distortion;
  return distortions[static_cast<std::size_t>(model)];
}

std::vector<double> distortion_coefficients(const Camera& camera) {
  std::vector<double> all = camera.coefficients;
  if (distortion_model(camera) == distortions[1]) all.resize(plumb_bob_numbers);
  return all;
}

std::array<double, 9> intrinsics(const Camera& camera) {
  const double f = camera.focal(), fx = camera.focal_length[0];
  const auto [cx, cy] = camera.principal_point;
  return {fx > 0 ? fx : f,
          0.0,
          cx > 0 ? cx : 0.5 * camera.width,
          0.0,
          f,
          cy > 0 ? cy : 0.5 * camera.height,
          0.0,
          0.0,
          1.0};
}

RosSchema camera_info_schema() { return {"sensor_msgs/msg/CameraInfo", std::string(camera_info_text)}; }

void encode_camera_info(std::vector<std::byte>& bytes, std::string_view frame, std::uint64_t time,
                        const Camera& camera) {
  const std::array<double, 9> K = intrinsics(camera);
  CdrEncoder to(bytes);
  put_header(to, time, frame);
  to.put(static_cast<std::uint32_t>(camera.height)).put(static_cast<std::uint32_t>(camera.width));
  const std::vector<double> coefficients = distortion_coefficients(camera);
  to.put(distortion_model(camera)).put(static_cast<std::uint32_t>(coefficients.size()));
  for (const double one : coefficients) to.put(one);
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
  const std::string_view model = from.string();
  const std::size_t count = from.length(sizeof(double));
  if (count > stated_coefficients_max) return std::nullopt;
  std::vector<double> coefficients(count);
  for (double& one : coefficients) one = from.number<double>();
  std::array<double, 9> k{};
  for (double& number : k) number = from.number<double>();
  constexpr std::uint32_t side_max = 1U << 16U;
  if (!from.ok() || !(k[0] > 0) || !std::isfinite(k[0]) || height > side_max || width > side_max)
    return std::nullopt;
  camera.height = static_cast<int>(height);
  camera.width = static_cast<int>(width);
  camera.field_of_view = 2 * std::atan(0.5 * height / k[0]);
  if (!set_distortion(camera, model, coefficients)) return std::nullopt;
  // Of a pinhole with its axis in the middle, field_of_view says all.
  const bool middle = k[2] == 0.5 * width && k[5] == 0.5 * height;
  if (camera.distortion == Distortion::none && k[0] == k[4] && middle) return camera;
  camera.focal_length = {k[0], k[4]};
  if (!middle) camera.principal_point = {k[2], k[5]};
  return camera;
}

CameraLog::CameraLog(const Scenario& scenario, MessageSink& to) : cameras_(scenario.vision.cameras), to_(to) {
  if (cameras_.empty()) return;
  constexpr LogTopic topic = log_topic("/OBSERVER/camera_info");
  const SchemaId schema = topic.add_schema(to, camera_info_schema().text);
  constexpr LogTopic further = log_topic("/OBSERVER/SENSOR/camera_info");
  for (const RobotCamera& one : scenario.vision.cameras) {
    const std::string_view name = scenario.team.name(one.observer);
    const bool first = scenario.vision.camera_of(one.observer) == &one;
    channels_.push_back(first ? topic.open(to, schema, name)
                              : further.open(to, schema, fmt::format("{}/{}", name, one.sensor)));
  }
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
