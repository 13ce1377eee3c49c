#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(VelocityMultirotor, EachVelocityFollowsItsCommandWithItsLag) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const auto tau = uniform_array<4>(random, 0.1, 2);
    const Model model =
        VelocityMultirotor{.tau_f = tau[0], .tau_s = tau[1], .tau_z = tau[2], .tau_psi = tau[3]};
    auto x = uniform_array<9>(random, -1, 1);
    const auto start = x;
    const auto u = uniform_array<4>(random, -3, 3);
    for (int step = 0; step < 100; ++step) {
      model.step(x.data(), u.data(), 0.01);
      ASSERT_TRUE(model.normalise(x.data()));
    }
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(x[5 + i], u[i] + (start[5 + i] - u[i]) * std::exp(-1.0 / tau[i]), 1e-5) << i;
    }
  }
}

TEST(VelocityMultirotor, SettlesAtTheVelocityInVAndTheYawRateItWasTold) {
  const Model model = VelocityMultirotor{};
  const std::array<double, 4> u = {1.3, -0.4, 0.7, 0.5};
  std::array<double, 9> x;
  model.at_rest({{}, {0.6, 0.8}}, x.data());
  for (int step = 0; step < 2000; ++step) {
    model.step(x.data(), u.data(), 0.01);
    ASSERT_TRUE(model.normalise(x.data()));
  }
  const Sight<double> seen = model.sight(x.data(), u.data());
  const Vec2<double> v_V = rotate<double>({seen.d.x, -seen.d.y}, {seen.v.x, seen.v.y});
  EXPECT_NEAR(v_V.x, u[0], 1e-9);
  EXPECT_NEAR(v_V.y, u[1], 1e-9);
  EXPECT_NEAR(seen.v.z, u[2], 1e-9);
  std::array<double, 9> rate;
  model.f(x.data(), u.data(), rate.data());
  EXPECT_NEAR(x[3] * rate[4] - x[4] * rate[3], u[3], 1e-9);
}

TEST(VelocityMultirotor, InTheLevelFrameYawingAloneTurnsNoVelocity) {
  Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    const auto start = uniform_array<9>(random, -1, 1);
    const auto coasts = [&](VelocityFrame frame, double yaw_rate) {
      const Model model = VelocityMultirotor{.tau_f = 0.6, .tau_s = 0.6, .frame = frame};
      std::array<double, 9> x = start;
      EXPECT_TRUE(model.normalise(x.data()));
      const std::array<double, 4> u = {0, 0, 0, yaw_rate};
      for (int step = 0; step < 100; ++step) model.step(x.data(), u.data(), 0.01);
      return model.sight(x.data(), u.data()).v;
    };
    const Vec3<double> straight = coasts(VelocityFrame::level, 0.0),
                       turned = coasts(VelocityFrame::level, 1.5);
    EXPECT_NEAR(turned.x, straight.x, 1e-8);
    EXPECT_NEAR(turned.y, straight.y, 1e-8);
    const Vec3<double> along = coasts(VelocityFrame::heading, 1.5);
    EXPECT_GT(norm(along.x - turned.x, along.y - turned.y), 0.1 * norm(turned.x, turned.y));
    EXPECT_NEAR(norm(along.x, along.y), norm(turned.x, turned.y), 1e-6);
  }
}

TEST(VelocityMultirotor, TheArDroneMovesInItsPlaneAsEquation24) {
  Random random(2);
  const Multirotor paper;
  const double fastest = paper.b_f / -paper.a_f;
  for (int k = 0; k < 1000; ++k) {
    const auto x = uniform_array<9>(random, -2, 2);
    const auto u = uniform_array<4>(random, -1, 1);
    const auto lagged =
        VelocityMultirotor::ar_drone().f<double>(x, {fastest * u[0], -fastest * u[1], u[2], u[3]});
    const auto expected = paper.f<double>({x[0], x[1], x[2], x[3], x[4], x[5], x[6]}, u);
    for (const std::size_t i : {0U, 1U, 5U, 6U}) EXPECT_NEAR(lagged[i], expected[i], 2e-15) << i;
  }
}

/// What a robot is seen to do under a command, from rest at the origin.
template <Lags lags>
Sight<double> seen_after(const LaggedMultirotor<lags>& robot, const std::array<double, 4>& u, int steps) {
  const Model model = robot;
  std::array<double, LaggedMultirotor<lags>::nx> x;
  model.at_rest({{}, {1, 0}}, x.data());
  for (int step = 0; step < steps; ++step) {
    model.step(x.data(), u.data(), 0.001);
    EXPECT_TRUE(model.normalise(x.data()));
  }
  return model.sight(x.data(), u.data());
}

TEST(VelocityMultirotor, AsItsLagsVanishItIsTheOneWithoutThem) {
  const VelocityMultirotor quick{.tau_z = 1e-3, .tau_psi = 1e-3};
  const std::array<double, 4> u = {1.0, -0.5, 0.4, 0.7};
  for (const int steps : {100, 1000}) {
    const Sight<double> expected = seen_after(LaggedMultirotor<Lags::plane>::of(quick), u, steps);
    for (const Sight<double>& seen :
         {seen_after(quick, u, steps), seen_after(LaggedMultirotor<Lags::climb>::of(quick), u, steps),
          seen_after(LaggedMultirotor<Lags::yaw>::of(quick), u, steps)}) {
      EXPECT_LE(norm(seen.p - expected.p), 2e-3);
      EXPECT_LE(norm(seen.v - expected.v), 2e-3);
      EXPECT_NEAR(seen.d.y, expected.d.y, 2e-3);
    }
  }
}

TEST(VelocityMultirotor, WithoutFurtherLagsItIsEquation24InOtherUnits) {
  Random random(3);
  const auto robot = LaggedMultirotor<Lags::plane>::of(VelocityMultirotor::ar_drone());
  const Multirotor paper{.b_z = 1.0, .b_psi = 1.0};
  for (int k = 0; k < 1000; ++k) {
    const auto x = uniform_array<7>(random, -2, 2);
    const auto u = uniform_array<4>(random, -1, 1);
    const auto rate = robot.f<double>(x, {robot.v_max * u[0], -robot.v_max * u[1], u[2], u[3]});
    const auto expected = paper.f<double>(x, u);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(rate[i], expected[i], 2e-15) << i;
  }
}

}  // namespace
}  // namespace sightline
