#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "sightline/vehicle.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr double imu_step = 0.002;
constexpr Imu perfect_imu = {.gyro_noise = 0,
                             .gyro_bias = 0,
                             .gyro_walk = 0,
                             .accelerometer_noise = 0,
                             .accelerometer_bias = 0,
                             .accelerometer_walk = 0};

Rotation tilted() { return rotation(leaning({0.6, 0.8}, {0.2, -0.1})); }
void fly(InertialErrors& errors, double duration, const Rotation& R = {}) {
  for (int k = 0; k < std::lround(duration / imu_step); ++k) errors.advance(R, imu_step);
}

TEST(Imu, WithoutErrorsTheFlightControllerKnowsTheTruthBitForBit) {
  InertialErrors errors(perfect_imu, 1, 0);
  fly(errors, 1.0, tilted());
  const RigidBody body = {.p = {1, 2, 3}, .v = {0.1, -0.2, 0.3}, .q = {0.9, 0.1, -0.3, 0.3}, .w = {1, 2, -3}};
  const RigidBody seen = errors.seen(body);
  EXPECT_EQ(seen.q, body.q);
  EXPECT_EQ(norm(seen.v - body.v) + norm(seen.w - body.w) + norm(seen.p - body.p), 0.0);
}

TEST(Imu, ABiasIsConstantWithinAFlightAndAnotherForEachSeedBodyAndSensor) {
  Imu imu = perfect_imu;
  imu.gyro_bias = imu.accelerometer_bias = 0.1;
  InertialErrors errors(imu, 1, 0);
  const Vec3<double> gyro = errors.gyro_bias(), accelerometer = errors.accelerometer_bias();
  fly(errors, 5.0);
  errors.begin({});
  fly(errors, 5.0);
  EXPECT_EQ(norm(errors.gyro_bias() - gyro), 0.0);
  EXPECT_EQ(norm(errors.accelerometer_bias() - accelerometer), 0.0);
  EXPECT_NE(InertialErrors(imu, 2, 0).gyro_bias().x, gyro.x);
  EXPECT_NE(InertialErrors(imu, 1, 1).gyro_bias().x, gyro.x);
  EXPECT_NE(gyro.x, accelerometer.x);
  EXPECT_EQ(InertialErrors(imu, 1, 0).gyro_bias().x, gyro.x);
}

TEST(Imu, BiasesOfManyFlightsHaveTheirStandardDeviationAndMeanZero) {
  Imu imu = perfect_imu;
  imu.gyro_bias = 0.02, imu.accelerometer_bias = 0.3;
  double gyro = 0, accelerometer = 0, mean = 0;
  constexpr int flights = 4000;
  for (int seed = 0; seed < flights; ++seed) {
    const InertialErrors errors(imu, static_cast<std::uint64_t>(seed), 3);
    const Vec3<double>&g = errors.gyro_bias(), &a = errors.accelerometer_bias();
    gyro += dot(g, g) / (3 * flights);
    accelerometer += dot(a, a) / (3 * flights);
    mean += (g.x + g.y + g.z) / (3 * flights);
  }
  EXPECT_NEAR(std::sqrt(gyro), 0.02, 0.03 * 0.02);
  EXPECT_NEAR(std::sqrt(accelerometer), 0.3, 0.03 * 0.3);
  EXPECT_NEAR(mean, 0.0, 0.03 * 0.02);
}

TEST(Imu, WhiteNoiseOfTheRatesHasTheDensityOverTheRootOfTheStep) {
  for (const double h : {0.001, 0.002, 0.01}) {
    Imu imu = perfect_imu;
    imu.gyro_noise = 1e-3;
    InertialErrors errors(imu, 5, 0);
    double variance = 0, correlated = 0;
    Vec3<double> before{};
    constexpr int n = 20'000;
    for (int k = 0; k < n; ++k) {
      errors.advance({}, h);
      variance += dot(errors.rate(), errors.rate()) / (3 * n);
      correlated += dot(errors.rate(), before) / (3 * n);
      before = errors.rate();
    }
    const double expected = square(1e-3) / h;
    EXPECT_NEAR(variance, expected, 0.05 * expected) << h;
    EXPECT_NEAR(correlated, 0.0, 0.05 * expected) << h;
  }
}

// The law by which a random walk shows in an Allan plot, for any step.
TEST(Imu, ABiasWalksByItsDensityTimesTheRootOfTheTime) {
  for (const double h : {0.002, 0.01}) {
    for (const double lag : {0.1, 1.0, 4.0}) {
      Imu imu = perfect_imu;
      imu.gyro_walk = 0.01, imu.accelerometer_walk = 0.2;
      double gyro = 0, accelerometer = 0;
      constexpr int flights = 40, parts = 25;
      for (int seed = 0; seed < flights; ++seed) {
        InertialErrors errors(imu, static_cast<std::uint64_t>(seed), 0);
        for (int part = 0; part < parts; ++part) {
          const Vec3<double> g = errors.gyro_bias(), a = errors.accelerometer_bias();
          for (int k = 0; k < std::lround(lag / h); ++k) errors.advance({}, h);
          const Vec3<double> moved_g = errors.gyro_bias() - g, moved_a = errors.accelerometer_bias() - a;
          gyro += dot(moved_g, moved_g) / (3 * flights * parts);
          accelerometer += dot(moved_a, moved_a) / (3 * flights * parts);
        }
      }
      EXPECT_NEAR(gyro, square(0.01) * lag, 0.1 * square(0.01) * lag) << h << ' ' << lag;
      EXPECT_NEAR(accelerometer, square(0.2) * lag, 0.1 * square(0.2) * lag) << h << ' ' << lag;
    }
  }
}

TEST(Imu, TheBiasOfTheAccelerometerTiltsTheEstimateByItsShareOfGAndLeavesNoLevelVelocity) {
  Imu imu = perfect_imu;
  imu.accelerometer_bias = 0.2;
  for (const Rotation& R : {Rotation{}, tilted()}) {
    InertialErrors errors(imu, 8, 0);
    errors.begin(R);
    fly(errors, 60.0, R);
    const Vec3<double> a = R.to_G(errors.accelerometer_bias());
    // Seen by R_estimated the specific force is straight up again.
    const RigidBody body = {.q = R.z.z == 1 ? Quaternion{} : leaning({0.6, 0.8}, {0.2, -0.1})};
    const Vec3<double> felt = R.to_B({0, 0, gravity}) + errors.accelerometer_bias();
    const Vec3<double> up = rotation(errors.seen(body).q).to_G(felt);
    EXPECT_LT(norm(up.x, up.y), 1e-2 * norm(a.x, a.y) + 1e-3);
    EXPECT_NEAR(norm(errors.attitude()), norm(a.x, a.y) / gravity, 1e-6);
    EXPECT_LT(norm(errors.velocity().x, errors.velocity().y), 1e-6);
    EXPECT_NEAR(errors.velocity().z, a.z / InertialErrors::velocity_gain, 1e-6);
  }
}

TEST(Imu, TheBiasOfTheGyroscopeIsEstimatedWithinAMinute) {
  Imu imu = perfect_imu;
  imu.gyro_bias = 0.02;
  InertialErrors errors(imu, 3, 0);
  double most = 0.0;
  for (int k = 0; k < 30'000; ++k) {
    errors.advance(tilted(), imu_step);
    most = std::max(most, norm(errors.attitude()));
  }
  const double bias = norm(errors.gyro_bias());
  EXPECT_GT(most, 0.5 * bias / InertialErrors::attitude_gain);
  EXPECT_LT(most, bias / InertialErrors::attitude_gain);
  EXPECT_LT(norm(errors.attitude()), 1e-3 * most);
  EXPECT_LT(norm(errors.rate()), 1e-3 * bias);
}

TEST(Imu, WhatIsSeenIsTurnedByTheAttitudeErrorAboutTheAxesOfG) {
  Imu imu = perfect_imu;
  imu.accelerometer_bias = 3.0;
  InertialErrors errors(imu, 4, 0);
  const Vec3<double> phi = errors.attitude();
  ASSERT_GT(norm(phi), 0.1);
  const RigidBody body = {.q = leaning({0.6, 0.8}, {0.2, -0.1})};
  const Rotation R = rotation(body.q), seen = rotation(errors.seen(body).q);
  const double angle = norm(phi);
  const Vec3<double> axis = (1 / angle) * phi;
  for (const auto& [was, is] : {std::pair{R.x, seen.x}, std::pair{R.y, seen.y}, std::pair{R.z, seen.z}}) {
    const Vec3<double> turned = std::cos(angle) * was + std::sin(angle) * cross(axis, was) +
                                ((1 - std::cos(angle)) * dot(axis, was)) * axis;
    EXPECT_LT(norm(turned - is), 1e-14);
  }
}

TEST(Imu, OneErrorLeavesTheOthersAsTheyWere) {
  const auto flown = [](const std::function<void(Imu&)>& on) {
    Imu imu = perfect_imu;
    imu.gyro_bias = imu.accelerometer_walk = 0.01;
    on(imu);
    InertialErrors errors(imu, 6, 0);
    fly(errors, 0.2);
    return errors;
  };
  const InertialErrors alone = flown([](Imu&) {});
  for (const auto& [on, gyro_walks, accelerometer_moves] :
       {std::tuple{std::function<void(Imu&)>([](Imu& i) { i.gyro_noise = 0.1; }), false, false},
        {[](Imu& i) { i.gyro_walk = 0.1; }, true, false},
        {[](Imu& i) { i.accelerometer_noise = 0.1; }, false, false},
        {[](Imu& i) { i.accelerometer_bias = 0.1; }, false, true}}) {
    const InertialErrors also = flown(on);
    EXPECT_EQ(norm(also.gyro_bias() - alone.gyro_bias()) == 0, !gyro_walks);
    EXPECT_EQ(norm(also.accelerometer_bias() - alone.accelerometer_bias()) == 0, !accelerometer_moves);
    EXPECT_NE(norm(also.rate() - alone.rate()) + norm(also.velocity() - alone.velocity()), 0.0);
  }
}

TEST(Imu, RefusesANumberBelowZeroOrNotFinite) {
  for (const auto& preset : Imu::presets()) EXPECT_NO_THROW(preset.part.check());
  for (double Imu::*const number :
       {&Imu::gyro_noise, &Imu::gyro_bias, &Imu::gyro_walk, &Imu::accelerometer_noise,
        &Imu::accelerometer_bias, &Imu::accelerometer_walk}) {
    for (const double bad : {-1e-9, std::numeric_limits<double>::infinity(), std::nan("")}) {
      Imu imu;
      imu.*number = bad;
      EXPECT_THAT(refusal_of([&] { InertialErrors(imu, 1, 0); }), HasSubstr("vehicle.imu."));
    }
  }
}

}  // namespace
}  // namespace sightline
