#include "sightline/readers/cdr.hpp"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>

#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

constexpr std::string_view rule =
    "================================================================================\n";
constexpr std::string_view pose_stamped = "std_msgs/Header header\ngeometry_msgs/Pose pose\n";
constexpr std::string_view header_text =
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
constexpr std::string_view pose_parts =
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n";
constexpr std::string_view quaternion_text =
    "MSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n";
constexpr std::string_view twist_parts =
    "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n";

std::string join(std::initializer_list<std::string_view> definitions) {
  std::string text;
  for (const std::string_view definition : definitions) {
    if (!text.empty()) text += rule;
    text += definition;
  }
  return text;
}

void put_all(CdrEncoder& to, std::span<const double> numbers) {
  for (const double x : numbers) to.put(x);
}

// Without tilt the rotation about z takes the x axis to d: (cos ψ/2, sin ψ/2) without computing an
// angle, w >= 0.
void put_pose(CdrEncoder& to, const StampedPose& pose) {
  const double length = norm(pose.d[0], pose.d[1]);
  const double c = pose.d[0] / length, s = pose.d[1] / length;
  if (pose.lean[0] != 0 || pose.lean[1] != 0) {
    const Quaternion q = leaning({c, s}, {pose.lean[0], pose.lean[1]});
    put_all(to, pose.p);
    to.put(q.x).put(q.y).put(q.z).put(q.w);
    return;
  }
  const double larger = std::sqrt(0.5 * (1 + std::abs(c)));
  const double smaller = 0.5 * std::abs(s) / larger;
  const double w = c >= 0 ? larger : smaller;
  const double z = std::copysign(c >= 0 ? smaller : larger, s);
  put_all(to, pose.p);
  to.put(0.0).put(0.0).put(z).put(w);
}

std::uint64_t read_header(CdrDecoder& from) {
  const auto seconds = static_cast<std::uint32_t>(from.number<std::int32_t>());
  const auto nanoseconds = from.number<std::uint32_t>();
  from.string();
  return seconds * std::uint64_t{one_second} + nanoseconds;
}

StampedPose read_pose(CdrDecoder& from) {
  StampedPose pose;
  pose.time = read_header(from);
  for (double& x : pose.p) x = from.number<double>();
  const auto x = from.number<double>(), y = from.number<double>(), z = from.number<double>(),
             w = from.number<double>();
  pose.d = {w * w + x * x - y * y - z * z, 2 * (w * z + x * y)};
  if (x == 0 && y == 0) return pose;
  const Rotation R = rotation({w, x, y, z});
  const Vec2<double> d = heading(R), tilt = lean(R);
  pose.d = {d.x, d.y};
  pose.lean = {tilt.x, tilt.y};
  return pose;
}

constexpr std::size_t least_pose = 12 + 1 + 7 * sizeof(double);  // header with an empty frame, and pose [B]

}  // namespace

void put_header(CdrEncoder& to, std::uint64_t time, std::string_view frame) {
  to.put(static_cast<std::int32_t>(time / one_second))
      .put(static_cast<std::uint32_t>(time % one_second))
      .put(frame);
}

RosSchema pose_schema() {
  return {"geometry_msgs/msg/PoseStamped", join({pose_stamped, header_text, pose_parts})};
}

RosSchema twist_schema() {
  return {"geometry_msgs/msg/TwistStamped",
          join({"std_msgs/Header header\ngeometry_msgs/Twist twist\n", header_text, twist_parts})};
}

RosSchema path_schema() {
  const std::string pose = fmt::format("MSG: geometry_msgs/PoseStamped\n{}", pose_stamped);
  return {"nav_msgs/msg/Path", join({"std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n", pose,
                                     header_text, pose_parts})};
}

RosSchema attitude_schema() {
  return {
      "geometry_msgs/msg/QuaternionStamped",
      join({"std_msgs/Header header\ngeometry_msgs/Quaternion quaternion\n", header_text, quaternion_text})};
}

RosSchema estimate_schema() {
  return {"geometry_msgs/msg/PoseWithCovarianceStamped",
          join({"std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose\n", header_text,
                "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n",
                pose_parts})};
}

void encode_pose(std::vector<std::byte>& bytes, std::string_view frame, const StampedPose& pose) {
  CdrEncoder to(bytes);
  put_header(to, pose.time, frame);
  put_pose(to, pose);
}

void encode_twist(std::vector<std::byte>& bytes, std::string_view frame, const StampedTwist& twist) {
  CdrEncoder to(bytes);
  put_header(to, twist.time, frame);
  put_all(to, twist.linear);
  put_all(to, twist.angular);
}

void encode_path(std::vector<std::byte>& bytes, std::string_view frame, std::uint64_t time,
                 std::span<const StampedPose> poses) {
  CdrEncoder to(bytes);
  put_header(to, time, frame);
  to.put(static_cast<std::uint32_t>(poses.size()));
  for (const StampedPose& pose : poses) {
    put_header(to, pose.time, frame);
    put_pose(to, pose);
  }
}

void encode_attitude(std::vector<std::byte>& bytes, std::string_view frame, const StampedAttitude& attitude) {
  CdrEncoder to(bytes);
  put_header(to, attitude.time, frame);
  put_all(to, attitude.q);
}

void encode_estimate(std::vector<std::byte>& bytes, std::string_view frame, const StampedPose& pose,
                     const PoseCovariance& covariance) {
  CdrEncoder to(bytes);
  put_header(to, pose.time, frame);
  put_pose(to, pose);
  put_all(to, covariance);
}

void encode_rigid_pose(std::vector<std::byte>& bytes, std::string_view frame, const std::array<double, 3>& p,
                       const StampedAttitude& attitude, const PoseCovariance* covariance) {
  CdrEncoder to(bytes);
  put_header(to, attitude.time, frame);
  put_all(to, p);
  put_all(to, attitude.q);
  if (covariance != nullptr) put_all(to, *covariance);
}

std::optional<std::pair<StampedPose, PoseCovariance>> decode_estimate(std::span<const std::byte> bytes) {
  CdrDecoder from(bytes);
  std::pair<StampedPose, PoseCovariance> read{read_pose(from), {}};
  for (double& part : read.second) part = from.number<double>();
  if (!from.finished()) return std::nullopt;
  return read;
}

std::optional<StampedAttitude> decode_attitude(std::span<const std::byte> bytes) {
  CdrDecoder from(bytes);
  StampedAttitude attitude;
  attitude.time = read_header(from);
  for (double& part : attitude.q) part = from.number<double>();
  if (!from.finished()) return std::nullopt;
  return attitude;
}

std::optional<StampedPose> decode_pose(std::span<const std::byte> bytes) {
  CdrDecoder from(bytes);
  const StampedPose pose = read_pose(from);
  if (!from.finished()) return std::nullopt;
  return pose;
}

std::optional<StampedTwist> decode_twist(std::span<const std::byte> bytes) {
  CdrDecoder from(bytes);
  StampedTwist twist;
  twist.time = read_header(from);
  for (double& v : twist.linear) v = from.number<double>();
  for (double& w : twist.angular) w = from.number<double>();
  if (!from.finished()) return std::nullopt;
  return twist;
}

std::optional<std::vector<StampedPose>> decode_path(std::span<const std::byte> bytes) {
  CdrDecoder from(bytes);
  read_header(from);
  std::vector<StampedPose> poses(from.length(least_pose));
  for (StampedPose& pose : poses) pose = read_pose(from);
  if (!from.finished()) return std::nullopt;
  return poses;
}

}  // namespace sightline
