#include "sightline/vehicle.hpp"

namespace sightline {
namespace {

const Imu& checked(const Imu& imu) {
  imu.check();
  return imu;
}

/// e_z x a_G / g: the apparent tilt of an accelerometer with this error at zero tilt.
Vec3<double> tilt_of(const Vec3<double>& a_G) { return {-a_G.y / gravity, a_G.x / gravity, 0.0}; }

}  // namespace

Imu Imu::icm20689() {
  Imu imu;
  imu.gyro_noise = 1.05e-4;
  imu.accelerometer_noise = 1.5e-3;
  return imu;
}

std::array<Preset<Imu>, 2> Imu::presets() { return {{{"bmi088", bmi088()}, {"icm20689", icm20689()}}}; }

InertialErrors::InertialErrors(const Imu& imu, std::uint64_t seed, int body)
    : imu_(checked(imu)),
      gyro_noise_(seed, StreamId::gyro_noise, body),
      gyro_walk_(seed, StreamId::gyro_bias, body),
      accelerometer_noise_(seed, StreamId::accelerometer_noise, body),
      accelerometer_walk_(seed, StreamId::accelerometer_bias, body),
      gyro_bias_(imu_.gyro_bias * gyro_walk_.normals()),
      accelerometer_bias_(imu_.accelerometer_bias * accelerometer_walk_.normals()) {
  begin({});
}

void InertialErrors::begin(const Rotation& R) noexcept {
  phi_ = -1.0 * tilt_of(R.to_G(accelerometer_bias_));
  rate_ = gyro_bias_;
  estimated_bias_ = v_ = {};
}

void InertialErrors::advance(const Rotation& R, double h) noexcept {
  const double fast = 1 / sqrt(h), slow = sqrt(h);
  if (imu_.gyro_walk > 0) gyro_bias_ = gyro_bias_ + (imu_.gyro_walk * slow) * gyro_walk_.normals();
  if (imu_.accelerometer_walk > 0)
    accelerometer_bias_ =
        accelerometer_bias_ + (imu_.accelerometer_walk * slow) * accelerometer_walk_.normals();
  rate_ = gyro_bias_ - estimated_bias_;
  Vec3<double> a = accelerometer_bias_;
  if (imu_.gyro_noise > 0) rate_ = rate_ + (imu_.gyro_noise * fast) * gyro_noise_.normals();
  if (imu_.accelerometer_noise > 0)
    a = a + (imu_.accelerometer_noise * fast) * accelerometer_noise_.normals();

  const Vec3<double> a_G = R.to_G(a), y = phi_ + tilt_of(a_G);
  const Vec3<double> pushed = {gravity * phi_.y, -gravity * phi_.x, 0.0};
  v_ = v_ + h * (pushed + a_G - velocity_gain * v_);
  phi_ = phi_ + h * (R.to_G(rate_) - attitude_gain * y);
  estimated_bias_ = estimated_bias_ + (h * bias_gain) * R.to_B(y);
}

RigidBody InertialErrors::seen(const RigidBody& body) const noexcept {
  RigidBody estimated = body;
  estimated.v = body.v + v_;
  estimated.w = body.w + rate_;
  // exp([phi]) multiplies from the left, because phi is in G.
  const double angle = norm(phi_);
  const SinCos<double> half = sincos(0.5 * angle);
  const Vec3<double> s = (angle > 0 ? half.sin / angle : 0.5) * phi_;
  const Quaternion& q = body.q;
  estimated.q = {
      half.cos * q.w - s.x * q.x - s.y * q.y - s.z * q.z, half.cos * q.x + s.x * q.w + s.y * q.z - s.z * q.y,
      half.cos * q.y - s.x * q.z + s.y * q.w + s.z * q.x, half.cos * q.z + s.x * q.y - s.y * q.x + s.z * q.w};
  return estimated;
}

}  // namespace sightline
