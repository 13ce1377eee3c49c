/// Helpers to fill ROS 2 messages: storage of strings and sequences, time stamps.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridges/dds/topics/conversion.hpp"
#include "sightline/record/camera_log.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {

/// Owner of a message's strings until it is written.
class RosStrings {
 public:
  char* operator()(std::string text) { return kept_.emplace_back(std::move(text)).data(); }

 private:
  std::deque<std::string> kept_;  // a deque, because its elements keep their addresses
};

/// Sets a message's sequence to elements that the caller owns.
template <class Sequence, class T>
void set_sequence(Sequence& sequence, std::vector<T>& elements) {
  sequence._buffer = elements.data();
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(elements.size());
  sequence._release = false;
}

inline builtin_interfaces_msg_dds__Time_ stamp_of(Nanoseconds realtime) {
  const RosTime t = to_ros(realtime);
  return {t.sec, t.nanosec};
}

inline geometry_msgs_msg_dds__Pose_ ros_pose(const Vec3<double>& p, const Quaternion& q) {
  return {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}};
}

/// CameraInfo of a camera; the caller fills the header.
/// @param distortion  its distortion_coefficients(); must outlive the message
inline sensor_msgs_msg_dds__CameraInfo_ camera_info(const Camera& camera, RosStrings& strings,
                                                    std::vector<double>& distortion) {
  const std::array<double, 9> K = intrinsics(camera);
  sensor_msgs_msg_dds__CameraInfo_ message{};
  message.height = static_cast<std::uint32_t>(camera.height);
  message.width = static_cast<std::uint32_t>(camera.width);
  message.distortion_model = strings(std::string(distortion_model(camera)));
  set_sequence(message.d, distortion);
  std::copy(K.begin(), K.end(), std::begin(message.k));
  for (std::size_t i = 0; i < 9; i += 4) message.r[i] = 1.0;
  for (std::size_t i = 0; i < 12; ++i) message.p[i] = i % 4 == 3 ? 0.0 : K[3 * (i / 4) + i % 4];
  return message;
}

}  // namespace sightline::dds
