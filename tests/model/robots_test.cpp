#include "sightline/robots.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <type_traits>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// One step of 0.01 s of any robot under a constant input, back on its manifold afterwards.
void fly(const Model& model, std::span<double> x, std::span<const double> u) {
  std::vector<double> rows(5 * x.size());
  const auto f = [&](std::span<const double> at, std::span<double> rate) {
    model.f(at.data(), u.data(), rate.data());
  };
  rk4_step(f, x, 0.01, {rows});
  ASSERT_TRUE(model.normalise(x.data()));
}

TEST(Multirotor, TheDefaultsAreTheArDrone) {
  const Multirotor m;
  EXPECT_EQ((std::array{m.b_z, m.b_psi, m.a_f, m.b_f, m.a_s, m.b_s}),
            (std::array{1.0, 1.6, -0.5092, 1.458, -0.5092, 1.458}));  // (16)
  const AngleMultirotor a;
  EXPECT_EQ((std::array{a.b_z, a.b_psi, a.a_f, a.b_f, a.a_s, a.b_s}),
            (std::array{m.b_z, m.b_psi, m.a_f, m.b_f, m.a_s, m.b_s}));
}

TEST(Multirotor, TheRateIsEquation24) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const auto c = uniform_array<6>(random, -2, 2);
    const Multirotor m{.b_z = c[0], .b_psi = c[1], .a_f = c[2], .b_f = c[3], .a_s = c[4], .b_s = c[5]};
    const auto x = uniform_array<7>(random, -2, 2);
    const auto u = uniform_array<4>(random, -1, 1);
    const auto [d_x, d_y, v_f, v_s] = std::array{x[3], x[4], x[5], x[6]};
    const std::array<double, 7> expected = {
        v_f * d_x - v_s * d_y,    v_f * d_y + v_s * d_x,   c[0] * u[2], -d_y * c[1] * u[3], d_x * c[1] * u[3],
        c[2] * v_f + c[3] * u[0], c[4] * v_s - c[5] * u[1]};
    const auto rate = m.f(x, u);
    for (std::size_t i = 0; i < rate.size(); ++i) EXPECT_LE(relative_error(rate[i], expected[i]), 1e-15) << i;
  }
}

TEST(AngleMultirotor, MovesAsTheDirectionVectorDoes) {
  Random random(3);
  for (int k = 0; k < 50; ++k) {
    const auto c = uniform_array<6>(random, -1, 1);
    const Model direction =
        Multirotor{.b_z = c[0], .b_psi = c[1], .a_f = c[2], .b_f = c[3], .a_s = c[4], .b_s = c[5]};
    const Model angle =
        AngleMultirotor{.b_z = c[0], .b_psi = c[1], .a_f = c[2], .b_f = c[3], .a_s = c[4], .b_s = c[5]};
    const Pose<double> start = random_pose(random, 2);
    std::array<double, 7> x;
    std::array<double, 6> y;
    direction.at_rest(start, x.data());
    angle.at_rest(start, y.data());
    std::array<double, 4> u{};
    for (int step = 0; step < 500; ++step) {
      if (step % 50 == 0) u = uniform_array<4>(random, -1, 1);
      fly(direction, x, u);
      fly(angle, y, u);
    }
    const Sight<double> a = direction.sight(x.data(), u.data()), b = angle.sight(y.data(), u.data());
    EXPECT_LE(norm(a.p - b.p), 1e-8);
    EXPECT_LE(norm(a.v - b.v), 1e-8);
    EXPECT_LE(std::hypot(a.d.x - b.d.x, a.d.y - b.d.y), 1e-8);
  }
}

TEST(Body, GoesOnWithTheVelocityItHas) {
  Random random(4);
  const Model body = Body{};
  for (int k = 0; k < 100; ++k) {
    const auto start = uniform_array<6>(random, -2, 2);
    auto x = start;
    for (int step = 0; step < 100; ++step) fly(body, x, {});
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(x[i], start[i] + start[i + 3], 1e-13);
      EXPECT_EQ(x[i + 3], start[i + 3]);
    }
  }
}

TEST(Lean, OfTiltCommandsIsTheCommandedAccelerationOverGravity) {
  Random random(11);
  for (int k = 0; k < 1000; ++k) {
    const auto c = uniform_array<2>(random, -3, 3);
    const Multirotor direction{.b_f = c[0], .b_s = c[1]};
    const AngleMultirotor angle{.b_f = c[0], .b_s = c[1]};
    const auto x = uniform_array<7>(random, -2, 2);
    const auto y = uniform_array<6>(random, -2, 2);
    const auto u = uniform_array<4>(random, -1, 1);
    for (const Vec2<double>& lean : {sight(direction, x, u).lean, sight(angle, y, u).lean}) {
      EXPECT_LE(relative_error(lean.x, c[0] * u[0] / 9.81), 1e-15);
      EXPECT_LE(relative_error(lean.y, -c[1] * u[1] / 9.81), 1e-15) << "u_s > 0 is to the right";
    }
  }
}

TEST(Lean, WithLagsIsTheStateOfTheTilt) {
  Random random(12);
  for (int k = 0; k < 1000; ++k) {
    const auto x = uniform_array<11>(random, -2, 2);
    const auto u = uniform_array<4>(random, -1, 1);
    const Sight<double> seen = sight(LaggingHoverMultirotor{}, x, u);
    EXPECT_LE(relative_error(seen.lean.x, x[7] / 9.81), 1e-15);
    EXPECT_LE(relative_error(seen.lean.y, x[8] / 9.81), 1e-15);
    const Sight<double> at_once = sight(HoverMultirotor{}, uniform_array<7>(random, -2, 2), u);
    EXPECT_LE(relative_error(at_once.lean.x, 2.0 * u[0] / 9.81), 1e-15);
    EXPECT_LE(relative_error(at_once.lean.y, -2.0 * u[1] / 9.81), 1e-15);
  }
}

TEST(Lean, UnderVelocityCommandsIsTheHorizontalAccelerationInGOverGravity) {
  Random random(13);
  const auto expect_acceleration = [&](const auto& model) {
    using M = std::decay_t<decltype(model)>;
    const Model any = model;
    for (int k = 0; k < 200; ++k) {
      auto x = uniform_array<M::nx>(random, -1, 1);
      ASSERT_TRUE(any.normalise(x.data()));
      const auto u = uniform_array<M::nu>(random, -1, 1);
      const double h = 1e-6;
      auto rate = model.f(x, u), later = x;
      for (std::size_t i = 0; i < x.size(); ++i) later[i] += h * rate[i];
      const Sight<double> now = any.sight(x.data(), u.data()), then = any.sight(later.data(), u.data());
      const Vec3<double> a = (1 / h) * (then.v - now.v);
      const Vec2<double> a_V = rotate<double>({now.d.x, -now.d.y}, {a.x, a.y});
      EXPECT_NEAR(now.lean.x, a_V.x / 9.81, 1e-5);
      EXPECT_NEAR(now.lean.y, a_V.y / 9.81, 1e-5);
    }
  };
  for (const VelocityFrame frame : {VelocityFrame::heading, VelocityFrame::level})
    expect_acceleration(VelocityMultirotor{.tau_f = 0.4, .tau_s = 0.7, .frame = frame});
  expect_acceleration(LaggedMultirotor<Lags::plane>{.tau_f = 0.4, .tau_s = 0.7});
  expect_acceleration(LaggedMultirotor<Lags::climb>{});
  expect_acceleration(PointMass{});
}

TEST(Lean, OfAPointMassLeavesDragToTheAirAndOnTheGroundThereIsNone) {
  const std::array<double, 6> x = {0, 0, 1, 2, 3, 0};
  const Sight<double> mass = sight(PointMass{.drag = 0.5}, x, std::array{0.981, -1.962, 0.3});
  EXPECT_NEAR(mass.lean.x, 0.1, 1e-15);
  EXPECT_NEAR(mass.lean.y, -0.2, 1e-15);
  const Vec2<double> rover =
      sight(OmniRover{}, std::array{0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0}, std::array{1.0, 1.0, 1.0}).lean;
  const Vec2<double> car =
      sight(Unicycle{}, std::array{0.0, 0.0, 0.0, 1.0, 0.0, 1.0}, std::array{1.0, 1.0}).lean;
  EXPECT_EQ((std::array{rover.x, rover.y, car.x, car.y}), (std::array{0.0, 0.0, 0.0, 0.0}));
}

}  // namespace
}  // namespace sightline
