#include "sightline/run/steady_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"

namespace sightline {
namespace {

TEST(SteadyState, StatesThatAreShownStayAndTheOthersFollowTheCommand) {
  const LaggingHoverMultirotor robot;
  const Model model = robot;
  std::vector<double> x = state_at_rest(model);
  x[5] = 0.7, x[9] = 0.2;
  const std::vector<double> u = {0.3, -0.2, 0.1, 0.4};
  const SteadyState settled = settle(model, x, u);
  for (const std::size_t shown : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 9U}) EXPECT_EQ(settled.x[shown], x[shown]);
  EXPECT_NEAR(settled.x[7], robot.b_f * 0.3, 1e-9);
  EXPECT_NEAR(settled.x[8], robot.b_s * 0.2, 1e-9);
  EXPECT_NEAR(settled.x[10], robot.b_psi * 0.4, 1e-9);
  EXPECT_NEAR(settled.lean.x, settled.x[7] / gravity, 1e-12);
  EXPECT_NEAR(settled.velocity.x, 0.7, 1e-12);
  EXPECT_NEAR(settled.velocity.z, 0.2, 1e-12);
  const double lift = 1 + (robot.b_z * 0.1 - 0.2) / robot.tau_z / gravity;
  EXPECT_NEAR(settled.acceleration.x, robot.a_f * 0.7 + lift * settled.x[7], 1e-5);
}

TEST(SteadyState, OfARobotWithoutInnerStatesIsTheStateItself) {
  for (const Model& model :
       {Model(Multirotor{}), Model(PointMass{}), Model(VelocityMultirotor{.tau_psi = 0.1})}) {
    const std::vector<char> shown = shown_states(model);
    const std::vector<double> x = state_at_rest(model), u(static_cast<std::size_t>(model.nu()), 0.5);
    const SteadyState settled = settle(model, x, u);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (shown[i]) {
        EXPECT_EQ(settled.x[i], x[i]) << model.name();
      }
    }
    EXPECT_GT(std::abs(settled.acceleration.x), 0.1) << model.name();
  }
}

TEST(SteadyState, TheTopSpeedIsThatOfTheModelUnderItsLimits) {
  const std::vector<double> low(4, -1.0), high(4, 1.0), half(4, 0.5), minus_half(4, -0.5);
  const Model multirotor = Multirotor{};
  // Its drag is linear: whatever it does, no component of a velocity under random inputs within the
  // limits is beyond.
  const double top = top_speed(multirotor, low, high);
  EXPECT_NEAR(top_speed(multirotor, minus_half, half), 0.5 * top, 1e-2 * top);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> within(-1, 1);
  double fastest = 0.0;
  for (int flight = 0; flight < 200; ++flight) {
    std::vector<double> x = state_at_rest(multirotor), u(4);
    for (int k = 0; k < 1000; ++k) {
      if (k % 50 == 0)
        for (double& v : u) v = within(random) > 0 ? 1.0 : -1.0;
      multirotor.step(x.data(), u.data(), 0.02);
      fastest = std::max(fastest, norm(multirotor.sight(x.data(), u.data()).v));
    }
  }
  EXPECT_LE(fastest, top * (1 + 1e-3));
  EXPECT_GT(fastest, 0.5 * top);
  EXPECT_TRUE(std::isinf(top_speed(PointMass{}, std::vector<double>(3, -1.0), std::vector<double>(3, 1.0))));
}

}  // namespace
}  // namespace sightline
