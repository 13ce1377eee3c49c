/// Motion of bodies and commanded velocities in a bag of ROS 2 (rosbag2 in MCAP).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/readers/recorded_motion.hpp"

namespace sightline {

/// Topics of a bag by what they give.
struct BagTopics {
  /// Of geometry_msgs/PoseStamped and nav_msgs/Odometry "/TOPIC"; of tf2_msgs/TFMessage and
  /// motion_capture_tracking_interfaces/NamedPoseArray "/TOPIC:NAME" for each child frame or body.
  std::vector<std::string> bodies;
  std::vector<std::string> commands;  ///< of geometry_msgs/TwistStamped and geometry_msgs/Twist
};

/// A bag, one file or a folder with metadata.yaml and its files. Messages are CDR, little-endian;
/// chunks are plain or compressed by zstd. Times are those of the headers, else of the recording.
///
/// A bag without its end is read up to the last complete chunk. Every other fault is refused.
class RosBag {
 public:
  /// @throws std::invalid_argument for a folder without MCAP; for a bag in SQLite (.db3) it says how
  ///   to convert it
  explicit RosBag(const std::filesystem::path& place);

  /// @throws std::invalid_argument naming the file, the byte and the fault
  BagTopics topics() const;
  /// The motion of a body in the frame of its messages. Without a velocity in the messages it is the
  /// slope of the positions within 0.05 s.
  /// @throws std::invalid_argument as topics(), and for an unknown body
  RecordedMotion motion(const std::string& body) const;
  /// Commands with velocities in the axes of the body's heading.
  /// @throws std::invalid_argument as topics(), and for an unknown topic
  std::vector<VelocityCommand> commands(const std::string& topic) const;

 private:
  std::string place_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace sightline
