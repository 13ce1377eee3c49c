#include "bridges/dds/simulators/crazyflie_body.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bridges/dds/simulators/vehicle_simulator.hpp"

namespace sightline::dds {
namespace {

constexpr double period = VehicleSimulator::period;

/// A Crazyflie that hovers at 1 m.
CrazyflieBody hovering() {
  CrazyflieBody body({0, 0, 0}, 0.0, Vehicle::crazyflie());
  for (int i = 0; i < 600; ++i) body.follow({.p = {0, 0, 1}, .d = {1, 0}});
  return body;
}

/// When a record first passes this value [s].
double passes(const std::vector<double>& record, double value) {
  const auto at = std::find_if(record.begin(), record.end(), [&](double one) { return one > value; });
  return period * static_cast<double>(at - record.begin() + 1);
}

// Figures of the firmware are of its Mellinger controller at 500 Hz, with a rigid body of 34 g and
// motor lags of 30 ms.
TEST(CrazyflieBody, AnswersAStepOfVelocityAsTheFirmware) {
  CrazyflieBody body = hovering();
  std::vector<double> v, behind;
  for (int i = 0; i < 300; ++i) {
    const double x = 0.5 * period * i;
    body.follow({.p = {x, 0, 1}, .v = {0.5, 0, 0}, .d = {1, 0}});
    v.push_back(body.motion().v.x);
    behind.push_back(x - body.motion().p.x);
  }
  EXPECT_NEAR(passes(v, 0.25), 0.198, 0.04);
  EXPECT_NEAR(passes(v, 0.45), 0.290, 0.06);
  EXPECT_NEAR(*std::max_element(behind.begin(), behind.end()), 0.098, 0.02) << "[m]";
  EXPECT_GT(*std::max_element(v.begin(), v.end()), 0.55) << "beyond it, to catch up; firmware: 0.735 m/s";
}

TEST(CrazyflieBody, AnswersStepsOfPositionAndHeadingAsTheFirmware) {
  CrazyflieBody body = hovering();
  std::vector<double> x, z, turned;
  for (int i = 0; i < 400; ++i) body.follow({.p = {0.5, 0, 1}, .d = {1, 0}}), x.push_back(body.motion().p.x);
  EXPECT_NEAR(passes(x, 0.25), 0.487, 0.05);
  EXPECT_NEAR(passes(x, 0.45), 0.760, 0.2);
  EXPECT_LT(*std::max_element(x.begin(), x.end()), 0.54) << "firmware: 0.535 m";
  for (int i = 0; i < 400; ++i)
    body.follow({.p = {0.5, 0, 1.3}, .d = {1, 0}}), z.push_back(body.motion().p.z - 1);
  EXPECT_NEAR(passes(z, 0.15), 0.277, 0.08);
  EXPECT_NEAR(passes(z, 0.27), 0.616, 0.1);
  for (int i = 0; i < 200; ++i) {
    body.follow({.p = {0.5, 0, 1.3}, .d = {std::cos(0.5), std::sin(0.5)}});
    const Vec2<double> d = heading(rotation(body.motion().q));
    turned.push_back(std::atan2(d.y, d.x));
  }
  EXPECT_NEAR(passes(turned, 0.25), 0.124, 0.05);
  EXPECT_NEAR(passes(turned, 0.45), 0.179, 0.08);
  EXPECT_NEAR(*std::max_element(turned.begin(), turned.end()), 0.555, 0.03);
}

TEST(CrazyflieBody, FollowsACircleByItsFeedForwardAsTheFirmware) {
  CrazyflieBody body = hovering();
  double late = 0;
  int n = 0;
  for (int i = 0; i < 2000; ++i) {
    const double t = period * i, blend = std::min(1.0, t / 3), a = t < 3 ? 0.5 * blend * t : t - 1.5,
                 w = blend, w_dot = t < 3 ? 1.0 / 3 : 0.0, s = std::sin(a), c = std::cos(a);
    body.follow({.p = {0.5 * c - 0.5, 0.5 * s, 1},
                 .v = {-0.5 * w * s, 0.5 * w * c, 0},
                 .a = {-0.5 * (w * w * c + w_dot * s), 0.5 * (w_dot * c - w * w * s), 0},
                 .d = {1, 0}});
    if (t < 8) continue;
    const Vec3<double> off = body.motion().p - Vec3<double>{0.5 * c - 0.5, 0.5 * s, 1};
    late += (off.x * s - off.y * c) / 0.5, ++n;  // along its way, over the speed
  }
  EXPECT_NEAR(late / n, 0.036, 0.02) << "[s] at 0.5 m/s";
}

TEST(CrazyflieBody, LevelledOutItCoastsAndKeepsItsHeight) {
  CrazyflieBody body = hovering();
  for (int i = 0; i < 200; ++i) body.follow({.p = {0.5 * period * i, 0, 1}, .v = {0.5, 0, 0}, .d = {1, 0}});
  const double v = body.motion().v.x;
  for (int i = 0; i < 150; ++i) body.level_out(1.0);
  EXPECT_NEAR(body.motion().p.z, 1.0, 0.02);
  EXPECT_NEAR(body.motion().v.x, v, 0.4 * v);
}

}  // namespace
}  // namespace sightline::dds
