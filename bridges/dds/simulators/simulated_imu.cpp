#include "bridges/dds/simulators/simulated_imu.hpp"

#include <cmath>

namespace sightline::dds {
namespace {

const Imu& checked_imu(const Imu& imu) {
  imu.check();
  return imu;
}

}  // namespace

InertialSample inertial_between(const Motion& before, const Motion& after, double dt) noexcept {
  const Quaternion& b = before.q;
  const Quaternion q = Quaternion{b.w, -b.x, -b.y, -b.z} * after.q;
  const Vec3<double> axis = {q.x, q.y, q.z};
  const double sine = norm(axis), angle = 2 * std::atan2(q.w < 0 ? -sine : sine, std::abs(q.w));
  const Vec3<double> w = (sine > 0 ? angle / (sine * dt) : 0.0) * axis;
  const Rotation middle = compose(rotation(b), turn_by((0.5 * dt) * w));
  const Vec3<double> a = (1.0 / dt) * (after.v - before.v);
  return {.gyro = w, .force = middle.to_B(a + Vec3<double>{0, 0, gravity})};
}

SimulatedImu::SimulatedImu(const Imu& imu, std::uint64_t seed)
    : imu_(checked_imu(imu)),
      gyro_noise_(seed, StreamId::gyro_noise, 0),
      gyro_walk_(seed, StreamId::gyro_bias, 0),
      force_noise_(seed, StreamId::accelerometer_noise, 0),
      force_walk_(seed, StreamId::accelerometer_bias, 0),
      gyro_bias_(imu_.gyro_bias * gyro_walk_.normals()),
      force_bias_(imu_.accelerometer_bias * force_walk_.normals()) {}

InertialSample SimulatedImu::measure(InertialSample exact, double dt) noexcept {
  const double fast = 1 / std::sqrt(dt), slow = std::sqrt(dt);
  gyro_bias_ = gyro_bias_ + (imu_.gyro_walk * slow) * gyro_walk_.normals();
  force_bias_ = force_bias_ + (imu_.accelerometer_walk * slow) * force_walk_.normals();
  exact.gyro = exact.gyro + gyro_bias_ + (imu_.gyro_noise * fast) * gyro_noise_.normals();
  exact.force = exact.force + force_bias_ + (imu_.accelerometer_noise * fast) * force_noise_.normals();
  return exact;
}

}  // namespace sightline::dds
