#include "bridges/dds/simulators/simulated_imu.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline::dds {
namespace {

constexpr double imu_step = 0.01;  // [s]

// R exp(w dt) = R', R_middle f dt = v' - v + g e_z dt, for turns below half a circle.
TEST(SimulatedImu, ItsMeansIntegrateToTheMotion) {
  RandomStream random(5, StreamId::draw, 0);
  for (int k = 0; k < 20'000; ++k) {
    Motion before, after;
    const Rotation R = turn_by(2.0 * random.normals());
    Vec3<double> turned = random.normals();
    turned = ((3.1 * random.uniform()) / norm(turned)) * turned;
    before.q = quaternion(R), after.q = quaternion(compose(R, turn_by(turned)));
    if (random.uniform() < 0.5)
      after.q = {-after.q.w, -after.q.x, -after.q.y, -after.q.z};  // the same attitude
    before.v = random.normals(), after.v = random.normals();
    const InertialSample mean = inertial_between(before, after, imu_step);
    EXPECT_LT(norm(imu_step * mean.gyro - turned), 1e-6);
    const Rotation middle = compose(R, turn_by(0.5 * turned));
    const Vec3<double> gained = imu_step * middle.to_G(mean.force) - Vec3<double>{0, 0, imu_step * gravity};
    EXPECT_LT(norm(gained - (after.v - before.v)), 1e-6);
  }
}

TEST(SimulatedImu, AtRestItMeasuresGravityUpwardsAndInFreeFallNothing) {
  Motion still;
  still.q = quaternion(turn_by({0.3, -0.2, 1.0}));
  const InertialSample rest = inertial_between(still, still, imu_step);
  EXPECT_LT(norm(rest.gyro), 1e-9);
  EXPECT_LT(norm(rotation(still.q).to_G(rest.force) - Vec3<double>{0, 0, gravity}), 1e-9);
  Motion falling = still;
  falling.v.z -= imu_step * gravity;
  EXPECT_LT(norm(inertial_between(still, falling, imu_step).force), 1e-9);
}

TEST(SimulatedImu, ItsErrorsAreThoseOfTheImu) {
  const Imu imu{.gyro_bias = 0.0, .gyro_walk = 0.0, .accelerometer_bias = 0.0, .accelerometer_walk = 0.0};
  SimulatedImu white(imu, 1), same(imu, 1), other(imu, 2);
  double gyro = 0.0, force = 0.0;
  int differ = 0;
  constexpr int times = 20'000;
  for (int k = 0; k < times; ++k) {
    const InertialSample one = white.measure({}, 0.005), again = same.measure({}, 0.005);
    gyro += square(norm(one.gyro)) / (3 * times), force += square(norm(one.force)) / (3 * times);
    EXPECT_EQ(one.gyro.x, again.gyro.x);
    EXPECT_EQ(one.force.z, again.force.z);
    differ += one.gyro.x != other.measure({}, 0.005).gyro.x ? 1 : 0;
  }
  EXPECT_GT(differ, times / 2);
  EXPECT_NEAR(std::sqrt(gyro) / (imu.gyro_noise / std::sqrt(0.005)), 1.0, 0.02);
  EXPECT_NEAR(std::sqrt(force) / (imu.accelerometer_noise / std::sqrt(0.005)), 1.0, 0.02);
  // The bias of each one is drawn, and lasts.
  const Imu biased{
      .gyro_noise = 0.0, .gyro_walk = 0.0, .accelerometer_noise = 0.0, .accelerometer_walk = 0.0};
  double gyro_bias = 0.0, force_bias = 0.0;
  constexpr int imus = 4'000;
  for (int k = 0; k < imus; ++k) {
    SimulatedImu drawn(biased, static_cast<std::uint64_t>(k));
    const InertialSample one = drawn.measure({}, 0.005), later = drawn.measure({}, 0.1);
    EXPECT_EQ(norm(one.gyro - later.gyro) + norm(one.force - later.force), 0.0);
    gyro_bias += square(norm(one.gyro)) / (3 * imus), force_bias += square(norm(one.force)) / (3 * imus);
  }
  EXPECT_NEAR(std::sqrt(gyro_bias) / biased.gyro_bias, 1.0, 0.05);
  EXPECT_NEAR(std::sqrt(force_bias) / biased.accelerometer_bias, 1.0, 0.05);
}

}  // namespace
}  // namespace sightline::dds
