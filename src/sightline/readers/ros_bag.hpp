/// Motion of bodies, commanded velocities and sightings of tags in a bag of ROS 2 (rosbag2 in MCAP).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sightline/readers/recorded_motion.hpp"
#include "sightline/readers/rig_recording.hpp"

namespace sightline {

/// Topics of a bag by what they give.
struct BagTopics {
  /// Of geometry_msgs/PoseStamped, PoseWithCovarianceStamped and nav_msgs/Odometry "/TOPIC"; of
  /// tf2_msgs/TFMessage, geometry_msgs/TransformStamped and
  /// motion_capture_tracking_interfaces/NamedPoseArray "/TOPIC:NAME" for each child frame or body.
  std::vector<std::string> bodies;
  std::vector<std::string> commands;  ///< of geometry_msgs/TwistStamped and geometry_msgs/Twist
};

/// The calibration of a camera, the first message of a topic of sensor_msgs/CameraInfo.
struct BagCamera {
  std::string topic, frame{};           ///< the frame of its optics
  std::uint32_t width = 0, height = 0;  ///< of its pictures [px]: binned, the region of interest alone
  std::string distortion_model{};       ///< "plumb_bob"
  std::vector<double> D{};              ///< coefficients of the distortion
  std::array<double, 9> K{}, R{};       ///< matrices of the camera [px] and of the rectification, row-major
  std::array<double, 12> P{};           ///< matrix (3 x 4) of the rectified picture [px]; all 0: unknown
};

/// What a camera rig recorded in a bag.
struct BagRig {
  /// Corners by apriltag_msgs/AprilTagDetectionArray, from the tag's bottom left counterclockwise, poses
  /// by nav_msgs/Odometry, and angular velocities by sensor_msgs/Imu.
  RigRows rows{};
  std::map<std::string, std::string>
      frames{};  ///< by their topics: of the camera, the odometry's body, the IMU
  std::set<std::string> odometries{}, imus{};  ///< all topics of such messages
  std::set<std::string> families{};            ///< of the tags
  std::vector<BagCamera> cameras{};            ///< as RosBag::cameras(), if asked for
  struct Mounting {
    std::string parent{};
    RigidPose pose{};  ///< of the child in it
  };
  std::map<std::string, Mounting> mountings{};  ///< by the child's frame; topics /tf_static

  /// The pose of another frame in a frame, by any number of mountings on one another, or on a common frame;
  /// empty if there are none.
  std::optional<RigidPose> pose_in(const std::string& frame, const std::string& other) const;
};

/// A bag, one file or a folder with its files; also the log of a run or its folder, of which run.mcap
/// counts. Messages are CDR; chunks are plain or compressed by zstd or lz4. Times are
/// those of the headers, or of the recording if all headers of a body are 0. A quaternion of 0 is an
/// unknown attitude.
///
/// A bag without its end is read up to the last complete chunk. Every other fault is refused.
class RosBag {
 public:
  /// @throws std::invalid_argument for a folder without MCAP; for a bag in SQLite (.db3) or of packed files
  ///   with the command that converts it
  explicit RosBag(const std::filesystem::path& place);

  /// @throws std::invalid_argument naming the file, the byte and the fault
  BagTopics topics() const;
  /// The motion of a body in the frame of its messages. NAME stands for the only one of /NAME/pose and
  /// "/TOPIC:NAME". Without a velocity in the messages it is the
  /// slope of the positions within 0.05 s.
  /// @throws std::invalid_argument as topics(), for an unknown body, and if more than 5 % of the
  ///   messages are not later than those before
  RecordedMotion motion(const std::string& body) const;
  /// Commands with velocities in the axes of the body's heading.
  /// @throws std::invalid_argument as motion()
  std::vector<VelocityCommand> commands(const std::string& topic) const;
  /// Cameras by their topics.
  /// @throws std::invalid_argument as topics()
  std::vector<BagCamera> cameras() const;
  /// Poses and angular velocities are those of two topics; unknown ones are left out. Times are those of the
  /// headers, or of the recording if all headers of a topic are 0.
  /// @throws std::invalid_argument as topics(), for times more than a day apart, and for tags of two families
  BagRig rig(const std::string& odometry_topic, const std::string& imu_topic, bool with_cameras) const;

 private:
  std::string body_called(const std::string& name) const;

  std::string place_;
  std::vector<std::filesystem::path> files_;
};

}  // namespace sightline
