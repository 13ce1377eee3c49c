#include "bridges/dds/links/motion_samples.hpp"

#include <cmath>

#include "sightline/base/now.hpp"
#include "sightline/estimator.hpp"

namespace sightline::dds {
namespace {

double heading_of(const Rotation& R) noexcept {
  const Vec2<double> d = heading(R);
  return std::atan2(d.y, d.x);
}

Vec3<double> in_V(const Motion& motion, double heading) noexcept { return turn_z(-heading) * motion.v; }

}  // namespace

std::optional<MotionSample> MotionSamples::take(const SeenMotion& seen, Nanoseconds origin) noexcept {
  const double passed = to_seconds(seen.stamp - last_.stamp);
  if (begun_ && passed < shortest) return std::nullopt;
  const SeenMotion before = std::exchange(last_, seen);
  if (!std::exchange(begun_, true)) return std::nullopt;
  const bool gap = passed > longest;
  const Rotation now = rotation(seen.motion.q), then = gap ? now : rotation(before.motion.q);
  const double psi = heading_of(now), psi_then = heading_of(then), turned = wrap(psi - psi_then);
  MotionSample sample;
  sample.dt = gap ? MotionSample{}.dt : passed;
  sample.t = to_seconds(seen.stamp - origin) - sample.dt;
  const double reported = gap ? seen.motion.r : 0.5 * (seen.motion.r + before.motion.r);
  const bool explained = std::abs(turned - reported * sample.dt) < unexplained;
  sample.yaw_rate = gap || !explained ? reported : turned / sample.dt;
  sample.v_V = in_V(seen.motion, psi);
  if (!gap) sample.v_V = 0.5 * (sample.v_V + in_V(before.motion, psi_then));
  // R_VB = turn_y(pitch) turn_x(roll), at the beginning of the sample
  sample.pitch = std::atan2(-then.x.z, std::hypot(then.y.z, then.z.z));
  sample.roll = std::atan2(then.y.z, then.z.z);
  return sample;
}

}  // namespace sightline::dds
