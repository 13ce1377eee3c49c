/// Filling in messages of ROS 2: the memory behind their strings and sequences, and their times.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridges/dds/conversion.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {

/// Strings of a message until it is written.
class Words {
 public:
  char* operator()(std::string text) { return kept_.emplace_back(std::move(text)).data(); }

 private:
  std::deque<std::string> kept_;  // whose elements stay where they are
};

/// A sequence of a message over elements that are kept elsewhere.
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

}  // namespace sightline::dds
