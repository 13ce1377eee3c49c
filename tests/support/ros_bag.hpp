/// Writes bags of ROS 2 by the published formats (MCAP, CDR), for the tests of their reader. Shares
/// no code with it.
#pragma once

#include <lz4frame.h>
#include <zstd.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "tests/support/lagging_flight.hpp"

namespace sightline::test {

/// One message in CDR: numbers stand at multiples of their own size.
class Cdr {
 public:
  template <class T>
  Cdr& operator<<(T number) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back('\0');
    bytes_.append(reinterpret_cast<const char*>(&number), sizeof(T));
    return *this;
  }
  Cdr& operator<<(const char* text) {
    *this << static_cast<std::uint32_t>(std::strlen(text) + 1);
    bytes_.append(text, std::strlen(text) + 1);
    return *this;
  }
  Cdr& operator<<(const Vec3<double>& v) { return *this << v.x << v.y << v.z; }
  Cdr& stamp(double t) {
    const double seconds = std::floor(t);
    return *this << static_cast<std::int32_t>(seconds)
                 << static_cast<std::uint32_t>(std::llround(1e9 * (t - seconds))) << "map";
  }
  Cdr& pose(const Vec3<double>& p, double psi) {
    return *this << p << 0.0 << 0.0 << std::sin(psi / 2) << std::cos(psi / 2);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_ = std::string("\0\1\0\0", 4);
};

/// A bag with one chunk.
class BagWriter {
 public:
  explicit BagWriter(std::string schema_encoding = "ros2msg")
      : schema_encoding_(std::move(schema_encoding)) {}

  /// @param type  empty: the channel has no schema
  void add(const std::string& topic, const std::string& type, double t, const Cdr& message) {
    auto [known, is_new] = channels_.try_emplace(topic, static_cast<std::uint16_t>(channels_.size() + 1));
    const std::uint16_t id = known->second;
    if (is_new) {
      const std::uint16_t schema = type.empty() ? std::uint16_t{0} : id;
      if (schema != 0)
        chunk_ += record(3, packed(id) + text(type) + text(schema_encoding_) + text("float64 x"));
      chunk_ += record(4, packed(id, schema) + text(topic) + text("cdr") + packed(std::uint32_t{0}));
    }
    const auto time = static_cast<std::uint64_t>(std::llround(1e9 * t));
    chunk_ += record(5, packed(id) + packed(std::uint32_t{0}) + packed(time, time) + message.bytes());
  }

  /// Channels without a message, of one schema.
  void add_channels(int count, const std::string& encoding) {
    constexpr std::uint16_t schema = 60'000;
    chunk_ += record(3, packed(schema) + text("Type") + text(encoding) + text("float64 x"));
    for (int k = 1; k <= count; ++k)
      chunk_ += record(4, packed(static_cast<std::uint16_t>(schema - k), schema) + text("/t") + text("cdr") +
                              packed(std::uint32_t{0}));
  }

  /// @param compression  "zstd", "lz4", or empty; any other is named, but not done
  std::string bytes(const std::string& compression) const {
    std::string inside = chunk_;
    if (compression == "zstd") {
      inside.resize(ZSTD_compressBound(chunk_.size()));
      inside.resize(ZSTD_compress(inside.data(), inside.size(), chunk_.data(), chunk_.size(), 3));
    }
    if (compression == "lz4") {
      inside.resize(LZ4F_compressFrameBound(chunk_.size(), nullptr));
      inside.resize(LZ4F_compressFrame(inside.data(), inside.size(), chunk_.data(), chunk_.size(), nullptr));
    }
    const std::uint64_t none = 0, size = chunk_.size(), packed_size = inside.size();
    return "\x89MCAP0\r\n" + record(1, text("ros2") + text("rosbag")) +
           record(6, packed(none, none, size) + packed(std::uint32_t{0}) + text(compression) +
                         packed(packed_size) + inside) +
           record(15, packed(std::uint32_t{0})) + record(2, packed(none, none) + packed(std::uint32_t{0})) +
           "\x89MCAP0\r\n";
  }

 private:
  static std::string text(const std::string& of) {
    return packed(static_cast<std::uint32_t>(of.size())) + of;
  }
  static std::string record(std::uint8_t kind, const std::string& content) {
    return packed(kind) + packed(std::uint64_t{content.size()}) + content;
  }

  std::string schema_encoding_, chunk_;
  std::map<std::string, std::uint16_t> channels_;
};

/// sensor_msgs/CameraInfo of a wide camera with a distortion.
inline Cdr camera_info(const char* model, std::initializer_list<double> coefficients) {
  Cdr camera;
  camera.stamp(0.0) << std::uint32_t{480} << std::uint32_t{640} << model
                    << static_cast<std::uint32_t>(coefficients.size());
  for (const double d : coefficients) camera << d;
  for (const double k : {420.5, 0.0, 321.0, 0.0, 419.0, 243.5, 0.0, 0.0, 1.0}) camera << k;
  for (int i = 0; i < 9; ++i) camera << (i % 4 == 0 ? 1.0 : 0.0);
  for (int i = 0; i < 12; ++i) camera << 0.0;
  for (int i = 0; i < 6; ++i) camera << std::uint32_t{0};  // no binning, no region
  return camera << std::uint8_t{0};
}

/// A flight as a motion capture, an odometry and a commander record it.
inline BagWriter bag_of(const LaggingFlight& flight) {
  BagWriter bag;
  bag.add("/camera/camera_info", "sensor_msgs/msg/CameraInfo", 0.0,
          camera_info("plumb_bob", {-0.25, 0.06, 0.001, -0.002, 0.0}));
  for (std::size_t k = 0; k < flight.rows.size(); k += 5) {
    const LaggingFlight::Row& row = flight.rows[k];
    const double c = std::cos(row.psi), s = std::sin(row.psi);
    const auto level = [&](const Vec3<double>& v) {
      return Vec3<double>{c * v.x + s * v.y, c * v.y - s * v.x, v.z};
    };
    const Vec3<double> zero{};
    Cdr pose, odometry, tf, named, command;
    pose.stamp(row.t).pose(row.p, row.psi);
    odometry.stamp(row.t) << "body";
    odometry.pose(row.p, row.psi);
    for (int i = 0; i < 36; ++i) odometry << 0.5;
    odometry << level(row.v) << Vec3<double>{0, 0, row.r};
    for (int i = 0; i < 36; ++i) odometry << 0.25;
    tf << std::uint32_t{2};
    tf.stamp(row.t) << "tag";
    tf.pose(zero, 0);
    tf.stamp(row.t) << "uav0";
    tf.pose(row.p, row.psi);
    named.stamp(row.t) << std::uint32_t{1} << "cf1";
    named.pose(row.p, row.psi);
    command.stamp(row.t) << level(row.u) << Vec3<double>{0, 0, row.u_psi};
    bag.add("/pose", "geometry_msgs/msg/PoseStamped", row.t, pose);
    bag.add("/odom", "nav_msgs/msg/Odometry", row.t, odometry);
    bag.add("/tf", "tf2_msgs/msg/TFMessage", row.t, tf);
    bag.add("/poses", "motion_capture_tracking_interfaces/msg/NamedPoseArray", row.t, named);
    bag.add("/cmd", "geometry_msgs/msg/TwistStamped", row.t, command);
  }
  return bag;
}

}  // namespace sightline::test
