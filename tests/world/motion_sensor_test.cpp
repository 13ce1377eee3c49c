#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sightline/sensors.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// Nearly without errors: white noise must be above 0.
FilterOptions nearly_exact() {
  FilterOptions o;
  o.velocity_noise = o.yaw_rate_noise = o.gyro_noise = o.accelerometer_noise = 1e-12;
  o.velocity_bias = o.yaw_rate_bias = o.tilt_bias = o.tilt_noise = o.gyro_bias = o.accelerometer_bias = 0.0;
  o.yaw_rate_walk = o.gyro_walk = o.accelerometer_walk = 0.0;
  return o;
}

// On a circle, leaning inwards as one that turns evenly does.
Vec3<double> on_circle(double t) { return {std::cos(t), std::sin(t), 1.0}; }
Mat<3, 3> leaning_inwards(double t) {
  return turn_z(t + 0.5 * std::numbers::pi) * tilt(-std::atan2(1.0, gravity), 0.0);
}

TEST(MotionSensor, WithoutErrorsItTellsTheMotion) {
  MotionSensor sensor(nearly_exact(), 1, 0);
  constexpr double dt = 0.01;
  for (int k = 1; k < 300; ++k) {
    const double t = k * dt;
    const MotionSample u =
        sensor.measure(t, dt, on_circle(t - dt), leaning_inwards(t - dt), on_circle(t), leaning_inwards(t));
    EXPECT_NEAR(u.t, t - dt, 1e-12);
    EXPECT_EQ(u.dt, dt);
    EXPECT_NEAR(u.v_V.x, 1.0, 1e-4);
    EXPECT_NEAR(u.v_V.y, 0.0, 1e-4);
    EXPECT_NEAR(u.yaw_rate, 1.0, 1e-9);
    EXPECT_NEAR(u.roll, -std::atan2(1.0, gravity), 1e-9);
    EXPECT_NEAR(u.pitch, 0.0, 1e-9);
    if (k < 2) continue;
    EXPECT_NEAR(norm(u.force), std::sqrt(1 + gravity * gravity), 1e-3);
    EXPECT_NEAR(u.force.y, 0.0, 1e-2) << "it leans by what it turns with";
    const Vec3<double> w_G = leaning_inwards(t - dt) * u.gyro;
    EXPECT_NEAR(w_G.z, 1.0, 1e-4);
    EXPECT_NEAR(norm(w_G), 1.0, 1e-4);
  }
}

TEST(MotionSensor, ACompassTellsTheHeadingTenTimesASecondAndChangesNothingElse) {
  FilterOptions with = nearly_exact();
  with.compass_noise = 0.05;
  MotionSensor sensor(with, 1, 0), none(nearly_exact(), 1, 0);
  constexpr double dt = 0.01;
  double squares = 0.0;
  int received = 0;
  for (int k = 1; k <= 10000; ++k) {
    const double t = k * dt;
    const MotionSample u = sensor.measure(t, dt, {}, turn_z(0.5), {}, turn_z(0.5));
    const MotionSample plain = none.measure(t, dt, {}, turn_z(0.5), {}, turn_z(0.5));
    EXPECT_FALSE(plain.compass);
    EXPECT_EQ(u.yaw_rate, plain.yaw_rate);
    EXPECT_EQ(u.v_V.x, plain.v_V.x);
    if (!u.compass) continue;
    ++received;
    squares += square(*u.compass - 0.5);
  }
  EXPECT_EQ(received, 1000);
  EXPECT_NEAR(std::sqrt(squares / received), 0.05, 0.005);
}

TEST(MotionSensor, ItsErrorsAreOfTheSizeThatIsSaid) {
  const FilterOptions errors;
  constexpr double dt = 0.01;
  double bias = 0.0, white = 0.0;
  constexpr int robots = 400;
  for (int i = 0; i < robots; ++i) {
    MotionSensor sensor(errors, 5, i);
    const MotionSample a = sensor.measure(dt, dt, {}, identity<3>(), {}, identity<3>());
    const MotionSample b = sensor.measure(2 * dt, dt, {}, identity<3>(), {}, identity<3>());
    bias += square(0.5 * (a.v_V.x + b.v_V.x)) / robots;
    white += square(a.v_V.x - b.v_V.x) / (2 * robots);
  }
  EXPECT_NEAR(std::sqrt(white), errors.velocity_noise, 0.005);
  EXPECT_NEAR(std::sqrt(bias - 0.5 * white), errors.velocity_bias, 0.01);
}

TEST(MotionSensor, SameSeedSameNumbersAndAnErrorOutOfItsRangeIsRefused) {
  MotionSensor a({}, 3, 1), b({}, 3, 1), c({}, 4, 1);
  const auto received = [](MotionSensor& s) {
    return s.measure(0.01, 0.01, {}, identity<3>(), {}, identity<3>()).v_V.x;
  };
  const double first = received(a);
  EXPECT_EQ(first, received(b));
  EXPECT_NE(first, received(c));
  FilterOptions bad;
  bad.gyro_noise = 0.0;
  EXPECT_EQ(refusal_of([&] { return MotionSensor(bad, 1, 0); }),
            "estimate.gyro_noise = 0, expected > 0 rad/s");
}

TEST(MotionSensor, TheErrorOfACompassHasTheStatedAutocorrelation) {
  constexpr double dt = 0.01;
  constexpr int robots = 3000;
  FilterOptions errors = nearly_exact();
  errors.compass_noise = 0.1, errors.compass_time = 0.5;
  double first = 0.0, both = 0.0;
  for (int i = 0; i < robots; ++i) {
    MotionSensor sensor(errors, 5, i);
    std::vector<double> measured;
    for (int k = 1; measured.size() < 4; ++k) {
      const MotionSample u = sensor.measure(k * dt, dt, {}, identity<3>(), {}, identity<3>());
      if (u.compass) measured.push_back(*u.compass / errors.compass_noise);
    }
    first += square(measured[0]) / robots;
    both += measured[0] * measured[3] / robots;
  }
  EXPECT_NEAR(first, 1.0, 4.5 * std::sqrt(2.0 / robots));
  EXPECT_NEAR(both, std::exp(-0.3 / errors.compass_time), 4.5 * std::sqrt(2.0 / robots));
}

}  // namespace
}  // namespace sightline
