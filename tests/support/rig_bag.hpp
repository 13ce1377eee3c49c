/// Bags of ROS 2 with the recording of a camera rig.
#pragma once

#include <array>
#include <string>

#include "sightline/readers/rig_recording.hpp"
#include "sightline/world/rigid_motion.hpp"
#include "tests/support/ros_bag.hpp"

namespace sightline::test {

inline Cdr& put_pose(Cdr& to, const RigidPose& at) {
  const Quaternion q = quaternion(at.R);
  return to << at.p << q.x << q.y << q.z << q.w;
}

inline Cdr transform(const std::string& parent, const std::string& child, const RigidPose& at) {
  Cdr message;
  message << std::uint32_t{1} << std::int32_t{0} << std::uint32_t{0} << parent.c_str() << child.c_str();
  put_pose(message, at);
  return message;
}

/// The rest of a CameraInfo beside the camera of the whole raw picture.
struct CalibrationBeside {
  double rectified = 0.0;  ///< focal length of P; 0: P is unknown
  double second = 0.0;     ///< P[3]
  Rotation R{};
  std::array<std::uint32_t, 6> part{};  ///< binning x, y; x, y, height and width of the region
};

inline Cdr calibration(const Camera& camera, const std::string& frame, const CalibrationBeside& beside) {
  const double rectified = beside.rectified;
  Cdr info;
  info << std::int32_t{0} << std::uint32_t{0} << frame.c_str() << static_cast<std::uint32_t>(camera.height)
       << static_cast<std::uint32_t>(camera.width)
       << std::string(distortions[static_cast<std::size_t>(camera.distortion)]).c_str()
       << static_cast<std::uint32_t>(camera.coefficients.size());
  for (const double d : camera.coefficients) info << d;
  const auto &f = camera.focal_length, &c = camera.principal_point;
  for (const double k : {f[0], 0.0, c[0], 0.0, f[1], c[1], 0.0, 0.0, 1.0}) info << k;
  const Mat<3, 3> R = matrix(beside.R);
  for (int i = 0; i < 9; ++i) info << R(i / 3, i % 3);
  const double one = rectified > 0 ? 1.0 : 0.0;
  for (const double p :
       {rectified, 0.0, one * c[0], beside.second, 0.0, rectified, one * c[1], 0.0, 0.0, 0.0, one, 0.0})
    info << p;
  for (const std::uint32_t number : beside.part) info << number;
  return info << std::uint8_t{0};
}

/// sensor_msgs/Imu of the frame map.
inline Cdr imu(double t, const Vec3<double>& omega, double covariance = 0.0) {
  Cdr message;
  message.stamp(t);
  for (int i = 0; i < 4 + 9; ++i) message << 0.0;
  message << omega << covariance;
  for (int i = 0; i < 8 + 3 + 9; ++i) message << 0.0;
  return message;
}

inline Cdr& put_tag(Cdr& to, const char* family, int id, const std::array<Vec2<double>, 4>& corners) {
  to << family << static_cast<std::int32_t>(id) << std::int32_t{0} << 1.0F << 80.0F << 0.0 << 0.0;
  for (const Vec2<double>& corner : corners) to << corner.x << corner.y;
  for (int i = 0; i < 9; ++i) to << 0.0;
  return to;
}

/// Sightings and odometry, with the header of each message or at the time of the recording alone.
inline BagWriter bag_of(const RigRecording& recording, bool stamped = true,
                        const std::string& odometry_topic = "/odom") {
  BagWriter bag;
  const auto stamp = [stamped](Cdr& message, double t, const std::string& frame) -> Cdr& {
    const double seconds = stamped ? std::floor(t) : 0.0;
    const auto nanoseconds = stamped ? std::llround(1e9 * (t - seconds)) : 0;
    return message << static_cast<std::int32_t>(seconds) << static_cast<std::uint32_t>(nanoseconds)
                   << frame.c_str();
  };
  for (const auto& one : recording.odometry) {
    Cdr odometry;
    stamp(odometry, one.t, "odom") << "base";
    put_pose(odometry, one.pose);
    for (int i = 0; i < 36 + 6 + 36; ++i) odometry << 0.5;
    bag.add(odometry_topic, "nav_msgs/msg/Odometry", one.t, odometry);
  }
  for (std::size_t k = 0; k < recording.sightings.size();) {
    const RigRecording::Sighting& first = recording.sightings[k];
    std::size_t end = k;
    while (end < recording.sightings.size() && recording.sightings[end].t == first.t &&
           recording.sightings[end].camera == first.camera)
      ++end;
    Cdr tags;
    stamp(tags, first.t, recording.cameras[first.camera].name) << static_cast<std::uint32_t>(end - k);
    for (; k < end; ++k) {
      const RigRecording::Sighting& z = recording.sightings[k];
      put_tag(tags, "36h11", recording.tags[z.tag].id, z.corners);
    }
    bag.add(recording.cameras[first.camera].topic, "apriltag_msgs/msg/AprilTagDetectionArray", first.t, tags);
  }
  return bag;
}

/// A bag whose cameras are in it as well, mounted on the body by way of another frame.
inline BagWriter bag_with_cameras(const RigRecording& recording, const CalibrationBeside& beside) {
  BagWriter bag = bag_of(recording);
  const RigidPose plate = {{0.1, 0.2, 0.3}, turn_by({0.1, -0.2, 0.3})};
  bag.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0, transform("/rig", "plate", plate));
  for (const RigRecording::RigCamera& one : recording.cameras) {
    bag.add("/" + one.name + "/camera_info", "sensor_msgs/msg/CameraInfo", 0.0,
            calibration(one.camera, one.name, beside));
    bag.add("/tf_static", "tf2_msgs/msg/TFMessage", 0.0,
            transform("plate", one.name, inverse(plate) * one.mounting));
  }
  return bag;
}

}  // namespace sightline::test
