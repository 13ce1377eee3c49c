#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(HoverMultirotor, IsEquation24AndTheTermThatKeepsItsVelocityInG) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const auto x = uniform_array<7>(random, -2, 2);
    const auto u = uniform_array<4>(random, -1, 1);
    const auto c = uniform_array<6>(random, -2, 2);
    const Multirotor paper{c[0], c[1], c[2], c[3], c[4], c[5]};
    const HoverMultirotor hover{c[0], c[1], c[2], c[3], c[4], c[5]};
    auto expected = paper.f<double>(x, u);
    const double r = c[1] * u[3];
    expected[5] += r * x[6];
    expected[6] -= r * x[5];
    const auto rate = hover.f<double>(x, u);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(rate[i], expected[i], 1e-14) << i;
  }
}

TEST(HoverMultirotor, WithoutDragAndTiltItsVelocityInGStaysWhileItYaws) {
  const Model model = HoverMultirotor{.a_f = 0.0, .a_s = 0.0};
  const std::array<double, 4> yaw = {0, 0, 0, 0.8};
  std::array<double, 7> x = {0, 0, 1, 0.6, 0.8, 0.7, -0.4};
  const Vec3<double> v = model.sight(x.data(), yaw.data()).v;
  for (int step = 0; step < 300; ++step) {
    model.step(x.data(), yaw.data(), 0.01);
    ASSERT_TRUE(model.normalise(x.data()));
  }
  const Vec3<double> later = model.sight(x.data(), yaw.data()).v;
  EXPECT_NEAR(later.x, v.x, 1e-7);
  EXPECT_NEAR(later.y, v.y, 1e-7);
}

TEST(LaggingHoverMultirotor, TiltClimbAndYawRateFollowTheirCommandsWithTheirLags) {
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const auto tau = uniform_array<3>(random, 0.05, 0.5);
    const LaggingHoverMultirotor robot{.tau = tau[0], .tau_z = tau[1], .tau_psi = tau[2]};
    const Model model = robot;
    const auto u = uniform_array<4>(random, -1, 1);
    std::array<double, 11> x;
    model.at_rest({{0, 0, 1}, {1, 0}}, x.data());
    for (int step = 0; step < 200; ++step) {
      model.step(x.data(), u.data(), 0.001);
      ASSERT_TRUE(model.normalise(x.data()));
    }
    const auto followed = [](double command, double lag) { return command * (1 - std::exp(-0.2 / lag)); };
    EXPECT_NEAR(x[7], followed(robot.b_f * u[0], tau[0]), 1e-9);
    EXPECT_NEAR(x[8], followed(-robot.b_s * u[1], tau[0]), 1e-9);
    EXPECT_NEAR(x[9], followed(robot.b_z * u[2], tau[1]), 1e-9);
    EXPECT_NEAR(x[10], followed(robot.b_psi * u[3], tau[2]), 1e-9);
  }
}

TEST(LaggingHoverMultirotor, AThrustThatLiftsMorePushesMore) {
  const LaggingHoverMultirotor robot{.a_f = 0.0, .tau_z = 0.2};
  std::array<double, 11> x = {0, 0, 1, 1, 0, 0, 0, 1.5, 0, 0, 0};
  const auto rate = robot.f<double>(x, {0, 0, 1, 0});
  EXPECT_NEAR(rate[9], robot.b_z / 0.2, 1e-12);
  EXPECT_NEAR(rate[5], 1.5 * (1 + rate[9] / 9.81), 1e-12)
      << "g tan(tilt) is that of a thrust that lifts the weight";
}

TEST(LaggingHoverMultirotor, AsItsLagsVanishItIsTheOneWithoutThem) {
  const HoverMultirotor plain;
  auto quick = LaggingHoverMultirotor::of(plain);
  quick.tau = quick.tau_z = quick.tau_psi = 1e-3;
  const std::array<double, 4> u = {1.0, -0.5, 0.0, 0.7};
  std::array<double, 7> x;
  std::array<double, 11> z;
  const Model a = plain, b = quick;
  a.at_rest({{0, 0, 1}, {1, 0}}, x.data());
  b.at_rest({{0, 0, 1}, {1, 0}}, z.data());
  for (int step = 0; step < 2000; ++step) {
    a.step(x.data(), u.data(), 5e-4);
    b.step(z.data(), u.data(), 5e-4);
  }
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(x[i], z[i], 5e-3) << i;
}

TEST(LaggingHoverMultirotor, RefusesSomeLagsWithoutTheOthers) {
  EXPECT_EQ(
      refusal_of([] { Model{LaggingHoverMultirotor{.tau_psi = 0.0}}; }),
      "hover_multirotor.tau, tau_z, tau_psi = 0.121, 0.231, 0 s, expected all three above 0 s, or none");
  EXPECT_EQ(refusal_of([] { Model{HoverMultirotor{.tau = 0.1}}; }),
            "hover_multirotor.tau, tau_z, tau_psi = 0.1, 0, 0 s, expected 0 s: its states do not lag");
}

}  // namespace
}  // namespace sightline
