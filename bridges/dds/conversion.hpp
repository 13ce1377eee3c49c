/// Frames and times between the team and what others send: pure, no message types.
///
/// G is ENU: x east, y north, z up; bodies are FLU: x forward, y to the left, z up. PX4 has NED (north, east, down) and FRD (forward,
/// right, down), counted from where the estimator of each vehicle started. ROS 2 is ENU and FLU, like us.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/base/fixed.hpp"
#include "sightline/model/frames.hpp"
#include "sightline/scenario/link.hpp"
#include "sightline/world/rigid_body.hpp"

namespace sightline::dds {

/// What a robot does, in G.
struct Motion {
  Vec3<double> p{};  ///< [m]
  Quaternion q{};    ///< of its body, FLU to ENU
  Vec3<double> v{};  ///< [m/s]
  double r = 0.0;    ///< rate of its heading, anticlockwise [rad/s]
};

/// NED to ENU, and back: the same.
constexpr Vec3<double> turned_over(const Vec3<double>& a) { return {a.y, a.x, -a.z}; }
/// FRD to FLU, and back.
constexpr Vec3<double> body_turned_over(const Vec3<double>& a) { return {a.x, -a.y, -a.z}; }

/// Of a body FRD in NED, as a body FLU in ENU; and back: the same.
Quaternion turned_over(const Quaternion& q);
/// The heading in ENU of a yaw in NED, clockwise from north, and back: pi/2 - yaw, in (-pi, pi].
double turned_over_yaw(double yaw);

/// A product of two turns: first b, then a.
Quaternion operator*(const Quaternion& a, const Quaternion& b);
/// Of length 1; no_attitude where it has none, or is not finite.
Quaternion normalised(const Quaternion& q);

/// Whether each number of it is, and it has an attitude.
bool is_finite(const Motion& motion);

/// What is said in the local frame, in G; and back.
Motion in_G(const LinkOrigin& origin, const Motion& local);
Motion in_local(const LinkOrigin& origin, const Motion& motion);

/// Latitude and longitude [deg], altitude [m].
struct GeoPoint {
  double latitude = 0.0, longitude = 0.0, altitude = 0.0;
};
/// East, north and up of a point from a reference near by, on PX4's sphere [m].
Vec3<double> east_north_up(const GeoPoint& point, const GeoPoint& reference);

/// What sets the pace of time stamps: nanoseconds since 1970, or of the monotonic clock.
using Nanoseconds = std::int64_t;
/// Later than any that is meant: of the year 2096 [us].
inline constexpr std::uint64_t last_microsecond = 4'000'000'000'000'000;
/// @param us  at most last_microsecond
constexpr Nanoseconds of_microseconds(std::uint64_t us) { return static_cast<Nanoseconds>(us) * 1000; }
constexpr Nanoseconds of_ros(std::int32_t sec, std::uint32_t nanosec) {
  return static_cast<Nanoseconds>(sec) * 1'000'000'000 + nanosec;
}
struct RosTime {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
constexpr RosTime to_ros(Nanoseconds t) {
  Nanoseconds sec = t / 1'000'000'000, rest = t % 1'000'000'000;
  if (rest < 0) sec -= 1, rest += 1'000'000'000;
  return {static_cast<std::int32_t>(sec), static_cast<std::uint32_t>(rest)};
}

/// Puts the stamps of another's clock on ours: a stamp plus the least delay of the last 10 s. Clocks that differ by a constant
/// differ no more then, and what is late in transport keeps its lateness beyond the least. One thread; allocates nothing.
class ClockOffset {
 public:
  /// @param stamp    by the other clock
  /// @param arrival  by ours, rising
  /// @return the stamp by ours, not after the arrival
  Nanoseconds on_ours(Nanoseconds stamp, Nanoseconds arrival) noexcept;
  /// Whether a stamp is none of a clock that jumped by more than a second into the future: it would make all others look old.
  bool fits(Nanoseconds stamp, Nanoseconds arrival) const noexcept {
    return !begun_ || arrival - stamp > least_ - slice;
  }
  /// The least arrival - stamp of the last 10 s.
  Nanoseconds least() const noexcept { return least_; }

 private:
  static constexpr Nanoseconds slice = 1'000'000'000;
  static constexpr std::size_t slices = 10;

  std::array<Nanoseconds, slices> least_of_{};
  std::array<std::int64_t, slices> slice_of_{};  // its number, from 1; 0: none
  Nanoseconds least_ = 0;
  bool begun_ = false;
};

}  // namespace sightline::dds
