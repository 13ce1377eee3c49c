/// Conversions of frames and times between the team and the messages: pure functions, no message
/// types.
///
/// G is ENU: x east, y north, z up. Bodies are FLU: x forward, y left, z up.
/// PX4 uses NED (north, east, down) and FRD (forward, right, down), with the origin where each
/// vehicle's estimator started. ROS 2 uses ENU and FLU, as here.
#pragma once

#include <array>
#include <cstdint>

#include "bridges/dds/fleet/link.hpp"
#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/model.hpp"
#include "sightline/world.hpp"

namespace sightline::dds {

/// Motion of a robot in G.
struct Motion {
  Vec3<double> p{};  ///< position [m]
  Quaternion q{};    ///< attitude of the body, FLU to ENU
  Vec3<double> v{};  ///< velocity [m/s]
  double r = 0.0;    ///< heading rate, anticlockwise [rad/s]
};

/// NED to ENU; the inverse is the same function.
constexpr Vec3<double> turned_over(const Vec3<double>& a) { return {a.y, a.x, -a.z}; }
/// FRD to FLU; the inverse is the same function.
constexpr Vec3<double> body_turned_over(const Vec3<double>& a) { return {a.x, -a.y, -a.z}; }

/// Attitude of an FRD body in NED, as that of an FLU body in ENU; the inverse is the same function.
Quaternion turned_over(const Quaternion& q);
/// ENU heading of a NED yaw (clockwise from north): pi/2 - yaw, in (-pi, pi]; the inverse is the
/// same function.
double turned_over_yaw(double yaw);

/// Product of two rotations: b first, then a.
Quaternion operator*(const Quaternion& a, const Quaternion& b);
/// q scaled to length 1; no_attitude if the length is outside (0.5, 2) or not finite.
Quaternion normalised(const Quaternion& q);

/// Whether all numbers are finite and the motion has an attitude.
bool is_finite(const Motion& motion);

/// A motion of the local frame, in G; and the inverse.
Motion in_G(const LinkOrigin& origin, const Motion& local);
Motion in_local(const LinkOrigin& origin, const Motion& motion);

/// Geodetic position: latitude and longitude [deg], altitude [m].
struct GeoPoint {
  double latitude = 0.0, longitude = 0.0, altitude = 0.0;
};
/// East, north and up of a point relative to a nearby reference, on PX4's spherical earth [m].
Vec3<double> east_north_up(const GeoPoint& point, const GeoPoint& reference);

/// Time stamp [ns]: since 1970 (real-time clock), or of the monotonic clock.
using Nanoseconds = std::int64_t;
/// Upper bound of plausible stamps [us], in the year 2096.
inline constexpr std::uint64_t last_microsecond = 4'000'000'000'000'000;
/// @param us  at most last_microsecond
constexpr Nanoseconds of_microseconds(std::uint64_t us) { return static_cast<Nanoseconds>(us) * 1000; }
constexpr Nanoseconds of_ros(std::int32_t sec, std::uint32_t nanosec) { return sec * one_second + nanosec; }
struct RosTime {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
};
constexpr RosTime to_ros(Nanoseconds t) {
  Nanoseconds sec = t / one_second, rest = t % one_second;
  if (rest < 0) sec -= 1, rest += one_second;
  return {static_cast<std::int32_t>(sec), static_cast<std::uint32_t>(rest)};
}

}  // namespace sightline::dds
