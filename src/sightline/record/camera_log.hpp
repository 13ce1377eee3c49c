/// Camera intrinsics of a run in the log: topic, message encoding and writer.
///
///     /OBSERVER/camera_info           sensor_msgs/CameraInfo of the first camera of a robot, in the
///                                     optical frame, once, in the first period: with its distortion
///     /OBSERVER/SENSOR/camera_info    of each further camera
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Maps an undistorted point of the optical frame (x right, y down, z ahead) to its pixel; 3 x 3,
/// row-major [px].
std::array<double, 9> intrinsics(const Camera& camera);

/// Word and coefficients of the distortion as ROS has them; a pinhole is a plumb_bob of five zeros.
std::string_view distortion_model(const Camera& camera);
std::vector<double> distortion_coefficients(const Camera& camera);

RosSchema camera_info_schema();  ///< sensor_msgs/msg/CameraInfo

/// Encodes one CameraInfo message.
/// @param frame  name of the optical frame: x right, y down, z ahead
/// @param time   stamp [ns]
void encode_camera_info(std::vector<std::byte>& bytes, std::string_view frame, std::uint64_t time,
                        const Camera& camera);
/// Decodes size and lens of a camera; all other members keep their defaults. Empty if the bytes are
/// no such message, or of an unknown distortion.
std::optional<Camera> decode_camera_info(std::span<const std::byte> bytes);

/// Writes the topics above.
class CameraLog {
 public:
  /// @param to  receives the messages; must outlive this object
  CameraLog(const Scenario& scenario, MessageSink& to);

  /// The first call writes one message for each camera; later calls do nothing.
  /// @param time  [s]
  void add(double time);

 private:
  std::vector<RobotCamera> cameras_;
  std::vector<McapChannel> channels_;
  MessageSink& to_;
  bool reported_ = false;
};

}  // namespace sightline
