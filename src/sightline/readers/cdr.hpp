/// CDR encoding of ROS 2 messages, and the message types of the log.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace sightline {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied as CDR_LE stores them, or turned");

/// A number that CDR aligns to a multiple of its own size, at most 8 bytes.
template <class T>
concept CdrNumber = std::is_arithmetic_v<T> && !std::same_as<T, bool> && sizeof(T) <= 8;

/// Encodes one message as XCDR1, little-endian (CDR_LE), as ROS 2 stores it. Clears `bytes` first;
/// allocates nothing once `bytes` has reached its final size.
class CdrEncoder {
 public:
  explicit CdrEncoder(std::vector<std::byte>& bytes) : bytes_(bytes) {
    bytes_.assign({std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}});
  }

  template <CdrNumber T>
  CdrEncoder& put(T value) {
    const std::size_t place = head + (bytes_.size() - head + sizeof(T) - 1) / sizeof(T) * sizeof(T);
    bytes_.resize(place + sizeof(T));
    std::memcpy(bytes_.data() + place, &value, sizeof(T));
    return *this;
  }

  /// Length including the terminating zero, then the characters.
  CdrEncoder& put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    const auto characters = std::as_bytes(std::span(text));
    bytes_.insert(bytes_.end(), characters.begin(), characters.end());
    bytes_.push_back(std::byte{0});
    return *this;
  }

 private:
  static constexpr std::size_t head = 4;  // alignment counts from the end of the encapsulation header [B]
  std::vector<std::byte>& bytes_;
};

/// Decodes XCDR1, little- or big-endian, without trusting it: past the end every value is zero and ok()
/// is false.
class CdrDecoder {
 public:
  explicit CdrDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    ok_ = bytes.size() >= head && bytes[0] == std::byte{0} && bytes[1] <= std::byte{1};
    big_ = ok_ && bytes[1] == std::byte{0};
  }

  template <CdrNumber T>
  T number() {
    T value{};
    place_ = head + (place_ - head + sizeof(T) - 1) / sizeof(T) * sizeof(T);
    const auto taken = take(sizeof(T));
    if (!ok_) return value;
    std::array<std::byte, sizeof(T)> of{};
    std::copy(taken.begin(), taken.end(), of.begin());
    if (big_) std::reverse(of.begin(), of.end());
    std::memcpy(&value, of.data(), sizeof(T));
    return value;
  }

  /// The view is valid as long as the bytes.
  std::string_view string() {
    const auto length = number<std::uint32_t>();
    const auto taken = take(length);
    ok_ = ok_ && length > 0 && taken.back() == std::byte{0};
    if (!ok_) return {};
    return {reinterpret_cast<const char*>(taken.data()), length - 1};
  }

  /// Length of a sequence whose elements take at least `least` bytes each.
  std::size_t length(std::size_t least) {
    const auto count = number<std::uint32_t>();
    ok_ = ok_ && count <= (bytes_.size() - place_) / least;
    return ok_ ? count : 0;
  }

  bool ok() const { return ok_; }
  bool finished() const {
    return ok_ && place_ == bytes_.size();
  }  ///< True if all bytes were read and none was missing.

 private:
  std::span<const std::byte> take(std::size_t count) {
    ok_ = ok_ && place_ <= bytes_.size() && count <= bytes_.size() - place_;
    if (!ok_) return {};
    place_ += count;
    return bytes_.subspan(place_ - count, count);
  }

  static constexpr std::size_t head = 4;
  std::span<const std::byte> bytes_;
  std::size_t place_ = head;
  bool ok_ = true, big_ = false;
};

/// std_msgs/Header.
/// @param time  [ns], below 2^31 s
void put_header(CdrEncoder& to, std::uint64_t time, std::string_view frame);

/// Position and heading at a time, in the frame of the message that contains it.
struct StampedPose {
  std::uint64_t time = 0;     ///< [ns], below 2^31 s
  std::array<double, 3> p{};  ///< position [m]
  std::array<double, 2> d{1,
                          0};  ///< heading (cos ψ, sin ψ) [-]; any length but 0 when encoded, 1 when decoded
  std::array<double, 2> lean{};  ///< tangent of the tilt, forward and to the left [-]
};

/// Velocity at a time, in the frame of the message that contains it.
struct StampedTwist {
  std::uint64_t time = 0;           ///< [ns], below 2^31 s
  std::array<double, 3> linear{};   ///< [m/s]
  std::array<double, 3> angular{};  ///< [rad/s]
};

/// Attitude at a time: the rotation from the body axes to the axes of the message's frame.
struct StampedAttitude {
  std::uint64_t time = 0;               ///< [ns], below 2^31 s
  std::array<double, 4> q{0, 0, 0, 1};  ///< unit quaternion (x, y, z, w)
};

/// Covariance of position and rotation about x, y, z, row-major [m^2], [m rad], [rad^2].
using PoseCovariance = std::array<double, 36>;

/// Name of the frame G in logs and on topics.
inline constexpr std::string_view frame_of_G = "map";

/// A ROS 2 message type as the log stores it.
struct RosSchema {
  std::string_view name;  ///< "geometry_msgs/msg/PoseStamped"
  std::string text;       ///< its definition followed by the definitions that it uses ("ros2msg")
};

RosSchema pose_schema();      ///< geometry_msgs/msg/PoseStamped
RosSchema twist_schema();     ///< geometry_msgs/msg/TwistStamped
RosSchema path_schema();      ///< nav_msgs/msg/Path
RosSchema attitude_schema();  ///< geometry_msgs/msg/QuaternionStamped
RosSchema estimate_schema();  ///< geometry_msgs/msg/PoseWithCovarianceStamped

/// Encode one message of the schemas above; `frame` names the frame of the numbers, "map".
void encode_pose(std::vector<std::byte>& bytes, std::string_view frame, const StampedPose& pose);
void encode_twist(std::vector<std::byte>& bytes, std::string_view frame, const StampedTwist& twist);
void encode_path(std::vector<std::byte>& bytes, std::string_view frame, std::uint64_t time,
                 std::span<const StampedPose> poses);

void encode_attitude(std::vector<std::byte>& bytes, std::string_view frame, const StampedAttitude& attitude);
void encode_estimate(std::vector<std::byte>& bytes, std::string_view frame, const StampedPose& pose,
                     const PoseCovariance& covariance);
/// A PoseStamped of any attitude, or with `covariance` a PoseWithCovarianceStamped.
void encode_rigid_pose(std::vector<std::byte>& bytes, std::string_view frame, const std::array<double, 3>& p,
                       const StampedAttitude& attitude, const PoseCovariance* covariance = nullptr);

/// Decode one message of the schemas above; empty if the bytes are no such message.
std::optional<StampedPose> decode_pose(std::span<const std::byte> bytes);
std::optional<StampedTwist> decode_twist(std::span<const std::byte> bytes);
std::optional<StampedAttitude> decode_attitude(std::span<const std::byte> bytes);
std::optional<std::pair<StampedPose, PoseCovariance>> decode_estimate(std::span<const std::byte> bytes);
std::optional<std::vector<StampedPose>> decode_path(std::span<const std::byte> bytes);

}  // namespace sightline
