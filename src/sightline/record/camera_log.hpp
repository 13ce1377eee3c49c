/// What the cameras of a run are, and what their detections are of, as a log keeps it.
///
///     /OBSERVER/camera_info   sensor_msgs/CameraInfo in the optical frame, once, in the first period: a pinhole without distortion
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/record/cdr.hpp"
#include "sightline/record/mcap.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// From a point of the optical frame (x right, y down, z ahead) to its pixel, 3 x 3, row by row [px].
std::array<double, 9> intrinsics(const Camera& camera);

RosSchema camera_info_schema();  ///< sensor_msgs/msg/CameraInfo

/// @param frame  the optical one: x right, y down, z ahead
void encode_camera_info(std::vector<std::byte>& bytes, std::string_view frame, std::uint64_t time,
                        const Camera& camera);
/// Size and focal length of a camera, what else it is at its default; nothing if the bytes are no such message.
std::optional<Camera> decode_camera_info(std::span<const std::byte> bytes);

/// Writes the topic above.
class CameraLog {
 public:
  /// The sink outlives this.
  CameraLog(const Scenario& scenario, MessageSink& to);

  /// The first time says what the cameras are.
  /// @param time  [s]
  void add(double time);

 private:
  std::vector<RobotCamera> cameras_;
  std::vector<McapChannel> channels_;
  MessageSink& to_;
  bool said_ = false;
};

}  // namespace sightline
