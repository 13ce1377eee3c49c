#include "sightline/run/settled.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model/hover_multirotor.hpp"
#include "sightline/model/point_mass.hpp"
#include "sightline/model/velocity_multirotor.hpp"

namespace sightline {
namespace {

TEST(Settled, StatesThatAreShownStayAndTheOthersFollowTheCommand) {
  const LaggingHoverMultirotor robot;
  const Model model = robot;
  std::vector<double> x = state_at_rest(model);
  x[5] = 0.7, x[9] = 0.2;
  const std::vector<double> u = {0.3, -0.2, 0.1, 0.4};
  const Settled settled = settle(model, x, u);
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

TEST(Settled, OfARobotWithoutInnerStatesIsTheStateItself) {
  for (const Model& model :
       {Model(Multirotor{}), Model(PointMass{}), Model(VelocityMultirotor{.tau_psi = 0.1})}) {
    const std::vector<char> shown = shown_states(model);
    const std::vector<double> x = state_at_rest(model), u(static_cast<std::size_t>(model.nu()), 0.5);
    const Settled settled = settle(model, x, u);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (shown[i]) {
        EXPECT_EQ(settled.x[i], x[i]) << model.name();
      }
    }
    EXPECT_GT(std::abs(settled.acceleration.x), 0.1) << model.name();
  }
}

}  // namespace
}  // namespace sightline
