#include "bridges/dds/simulators/crazyflie_body.hpp"

#include <cmath>

namespace sightline::dds {
namespace {

// Gains of the firmware's controller [N/m], [N s/m]. Those of heading [1/s] are fitted to its
// response to a step.
constexpr double kp_xy = 0.4, kd_xy = 0.2, kp_z = 1.25, kd_z = 0.4;
constexpr double heading_gain = 8.0, yaw_gain = 14.0;

Vehicle with_firmware(Vehicle rotors) {
  rotors.velocity_gain = kd_xy / rotors.mass;
  rotors.climb_gain = kd_z / rotors.mass;
  rotors.yaw_gain = yaw_gain;
  return rotors;
}

}  // namespace

CrazyflieBody::CrazyflieBody(const Vec3<double>& p, double heading, Vehicle rotors)
    : body_(p, heading, with_firmware(std::move(rotors))) {}

void CrazyflieBody::follow(const TrajectoryPoint& to) noexcept {
  const Motion& m = motion();
  const Vec2<double> d = heading(rotation(m.q)), turn = rotate<double>({d.x, -d.y}, to.d);
  const Vec3<double> away = to.p - m.p;
  constexpr double level = kp_xy / kd_xy, up = kp_z / kd_z;
  body_.follow(to.v + Vec3<double>{level * away.x, level * away.y, up * away.z}, to.a,
               to.r + heading_gain * std::atan2(turn.y, turn.x));
}

void CrazyflieBody::level_out(double height) noexcept {
  const Motion& m = motion();
  body_.follow({m.v.x, m.v.y, kp_z / kd_z * (height - m.p.z)}, {}, 0.0);
}

}  // namespace sightline::dds
