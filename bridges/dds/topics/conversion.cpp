#include "bridges/dds/topics/conversion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sightline::dds {
namespace {

constexpr double earth_radius = 6371000.0;  // of PX4's map projection [m]

/// NED axes in ENU: half a turn about north-east.
const Quaternion ned_to_enu = {0.0, std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, 0.0};
const Quaternion frd_to_flu = {0.0, 1.0, 0.0, 0.0};

/// q or -q, whichever has w >= 0.
Quaternion upper(const Quaternion& q) { return q.w < 0 ? Quaternion{-q.w, -q.x, -q.y, -q.z} : q; }

Motion turned(const Motion& motion, double heading) {
  const Vec2<double> d = {std::cos(heading), std::sin(heading)};
  const Vec2<double> p = rotate<double>(d, {motion.p.x, motion.p.y}),
                     v = rotate<double>(d, {motion.v.x, motion.v.y});
  const Quaternion turn = {std::cos(heading / 2), 0.0, 0.0, std::sin(heading / 2)};
  return {{p.x, p.y, motion.p.z}, turn * motion.q, {v.x, v.y, motion.v.z}, motion.r};
}

}  // namespace

Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Quaternion normalised(const Quaternion& q) {
  const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(length > 0.5 && length < 2.0)) return no_attitude;  // PX4 and ROS send unit quaternions
  return {q.w / length, q.x / length, q.y / length, q.z / length};
}

bool is_finite(const Motion& m) {
  const double sum = m.p.x + m.p.y + m.p.z + m.v.x + m.v.y + m.v.z + m.r;
  return std::isfinite(sum) && m.q != no_attitude;
}

Quaternion turned_over(const Quaternion& q) { return upper(ned_to_enu * q * frd_to_flu); }

double turned_over_yaw(double yaw) {
  const double heading = std::remainder(std::numbers::pi / 2 - yaw, 2 * std::numbers::pi);
  return heading <= -std::numbers::pi ? std::numbers::pi : heading;
}

Motion in_G(const LinkOrigin& origin, const Motion& local) {
  Motion motion = turned(local, origin.heading);
  motion.p = origin.p + motion.p;
  return motion;
}

Motion in_local(const LinkOrigin& origin, const Motion& motion) {
  Motion from = motion;
  from.p = motion.p - origin.p;
  return turned(from, -origin.heading);
}

Vec3<double> east_north_up(const GeoPoint& point, const GeoPoint& reference) {
  constexpr double degree = std::numbers::pi / 180;
  return {
      earth_radius * std::cos(reference.latitude * degree) * (point.longitude - reference.longitude) * degree,
      earth_radius * (point.latitude - reference.latitude) * degree, point.altitude - reference.altitude};
}

}  // namespace sightline::dds
