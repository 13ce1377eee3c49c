#include <cmath>

#include "sightline/base.hpp"
#include "sightline/sensors.hpp"

namespace sightline {
namespace {

const FilterOptions& checked_errors(const FilterOptions& errors) {
  errors.check();
  return errors;
}

constexpr std::uint64_t stream_of_motion = 0x6d6f74696f6eULL;  // separate from the streams of the
                                                               // disturbances

constexpr std::uint64_t stream_of_compass = 0x636f6d70617373ULL;

/// Rotation vector of a rotation by less than pi / 2.
Vec3<double> turn_vector(const Mat<3, 3>& R) {
  const Vec3<double> s = {0.5 * (R(2, 1) - R(1, 2)), 0.5 * (R(0, 2) - R(2, 0)), 0.5 * (R(1, 0) - R(0, 1))};
  const double sine = norm(s), cosine = 0.5 * (trace(R) - 1);
  return sine > 1e-9 ? (atan2(sine, cosine) / sine) * s : s;
}

}  // namespace

MotionSensor::MotionSensor(const FilterOptions& errors, std::uint64_t seed, int body)
    : errors_(checked_errors(errors)),
      chance_(seed ^ stream_of_motion, StreamId::motion, body),
      velocity_bias_(errors_.velocity_bias * chance_.normals()),
      gyro_bias_(errors_.gyro_bias * chance_.normals()),
      force_bias_(errors_.accelerometer_bias * chance_.normals()),
      yaw_rate_bias_(errors_.yaw_rate_bias * chance_.normal()),
      magnetic_(seed ^ stream_of_compass, StreamId::motion, body),
      compass_error_(errors_.compass_time) {
  tilt_error_.x = errors_.tilt_bias * chance_.normal();
  tilt_error_.y = errors_.tilt_bias * chance_.normal();
}

MotionSample MotionSensor::measure(double t, double dt, const Vec3<double>& p_before,
                                   const Mat<3, 3>& R_before, const Vec3<double>& p,
                                   const Mat<3, 3>& R) noexcept {
  const MarkovStep bias(dt, errors_.velocity_bias_time), tilting(dt, errors_.tilt_time);
  const double slow = sqrt(dt), white = sqrt(FilterOptions::white_period / dt);
  velocity_bias_ = bias.keep * velocity_bias_ + (errors_.velocity_bias * bias.fresh) * chance_.normals();
  const double tilt_step = errors_.tilt_bias * tilting.fresh;
  tilt_error_.x = tilting.keep * tilt_error_.x + tilt_step * chance_.normal();
  tilt_error_.y = tilting.keep * tilt_error_.y + tilt_step * chance_.normal();
  yaw_rate_bias_ += errors_.yaw_rate_walk * slow * chance_.normal();
  gyro_bias_ = gyro_bias_ + (errors_.gyro_walk * slow) * chance_.normals();
  force_bias_ = force_bias_ + (errors_.accelerometer_walk * slow) * chance_.normals();

  const double psi = yaw_of(R_before), turned = wrap(yaw_of(R) - psi);
  const Vec3<double> v = (1 / dt) * (p - p_before);
  const Vec3<double> a = moved_ ? (1 / dt) * (v - v_before_) : Vec3<double>{};
  v_before_ = v;
  moved_ = true;
  const Mat<3, 3> level = turn_z(-psi) * R_before;  // R_VB = turn_y(pitch) turn_x(roll)
  MotionSample u{.t = t - dt, .dt = dt};
  u.v_V =
      turn_z(-psi - 0.5 * turned) * v + velocity_bias_ + (white * errors_.velocity_noise) * chance_.normals();
  u.yaw_rate = turned / dt + yaw_rate_bias_ + white * errors_.yaw_rate_noise * chance_.normal();
  u.pitch = atan2(-level(2, 0), norm(level(2, 1), level(2, 2))) - tilt_error_.y;
  u.roll = atan2(level(2, 1), level(2, 2)) - tilt_error_.x;
  u.roll += errors_.tilt_noise * chance_.normal();
  u.pitch += errors_.tilt_noise * chance_.normal();
  const Mat<3, 3> to_B = transposed(R_before);
  u.gyro = (1 / dt) * turn_vector(to_B * R) + gyro_bias_ + (white * errors_.gyro_noise) * chance_.normals();
  u.force = to_B * (a + Vec3<double>{0, 0, gravity}) + force_bias_ +
            (white * errors_.accelerometer_noise) * chance_.normals();
  if (errors_.compass_noise > 0 && u.t >= next_compass_ - same_time) {
    next_compass_ = u.t + 1 / FilterOptions::compass_rate;
    const double error = compass_error_.at(u.t, {{{{magnetic_.normal()}}}})(0, 0);
    u.compass = wrap(psi + errors_.compass_noise * error);
  }
  return u;
}

}  // namespace sightline
