#include "bridges/dds/links/robot_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/refusal.hpp"

namespace sightline::dds {
namespace {

const std::vector<Model> robots = {Multirotor{},
                                   AngleMultirotor{},
                                   LaggedMultirotor<Lags::plane>{},
                                   LaggedMultirotor<Lags::climb>{},
                                   VelocityMultirotor{},
                                   LaggedHoverMultirotor<HoverLags::none>{},
                                   OmniRover{},
                                   Unicycle{},
                                   PointMass{}};

// What a model shows at a state is written back as that state.
TEST(RobotState, OfEachRobotTheStateIsThatOfItsMotion) {
  std::mt19937 random(1);
  std::uniform_real_distribution<> number(-1, 1);
  for (const Model& model : robots) {
    RobotState state(model);
    for (int k = 0; k < 200; ++k) {
      std::vector<double> x(static_cast<std::size_t>(model.nx())), u(static_cast<std::size_t>(model.nu())),
          y(x);
      for (double& v : x) v = number(random);
      ASSERT_TRUE(model.normalise(x.data()));
      state.write(state.motion(x.data(), u.data()), y.data());
      for (std::size_t i = 0; i < x.size(); ++i) {
        // A rate that is a state is one of the motion too; one that is commanded is not.
        EXPECT_NEAR(y[i], x[i], 1e-9) << model.name() << " " << model.states()[i];
      }
    }
  }
}

TEST(RobotState, OfATextRobotTheRateOfTheHeadingHasAnyName) {
  RobotState state(TextRobot{
      .states = {"x", "y", "z", "yaw", "omega"},
      .inputs = {"w"},
      .f = {"0", "0", "0", "omega", "w - omega"},
      .position = {"x", "y", "z"},
      .heading = {
          "yaw"}}.model());
  std::vector<double> x(5);
  state.write({{1, 2, 3}, upright({0.6, 0.8}), {}, 0.7}, x.data());
  EXPECT_EQ(x[4], 0.7);
}

TEST(RobotState, AStateThatNobodyMeasuresIsRefused) {
  EXPECT_THAT(refusal_of([] { RobotState(LaggedHoverMultirotor<HoverLags::all>{}); }),
              testing::StartsWith("the state a_f of the robot hover_multirotor is not measured"));
}

TEST(RobotState, TheHeadingRateIsThatOfTheModelAMomentLater) {
  RobotState state(Multirotor{});  // b_psi u_psi at once
  const std::vector<double> x = {1, 2, 3, 0, 1, 0.4, 0.0}, turning = {0, 0, 0, 0.5};
  EXPECT_NEAR(state.command(x.data(), turning.data(), 0.01).r, 1.6 * 0.5, 1e-9);
  RobotState lags(VelocityMultirotor{});
  const std::vector<double> at = {0, 0, 1, 1, 0, 0, 0, 0, 0}, u = {1, 0, 0.35, 0.2};
  EXPECT_NEAR(lags.command(at.data(), u.data(), 0.01).r, 0.2 * (1 - std::exp(-RobotState::ahead / 0.2)),
              1e-5);
}

// A rover that is commanded velocities receives the one that its model would end at: b_f u / -a_f.
TEST(RobotState, TheEndOfAVelocityIsWhereTheModelNoLongerAccelerates) {
  const OmniRover rover{.a_f = -2.0, .b_f = 3.0, .a_s = -4.0, .b_s = 2.0};
  RobotState state(rover);
  const std::vector<double> x = {0, 0, 0, 0, 1, 0.7, -0.3}, u = {0.5, -0.4, 0.1};
  const Command c = state.command(x.data(), u.data(), 0.01);
  EXPECT_NEAR(c.v_end.y, 0.5 * 3.0 / 2.0, 1e-9);
  EXPECT_NEAR(c.v_end.x, -0.4 * 2.0 / 4.0, 1e-9);
  RobotState mass(PointMass{});  // which never ends
  const std::vector<double> p = {0, 0, 0, 1, 0, 0}, push = {2, 0, 0};
  EXPECT_NEAR(mass.command(p.data(), push.data(), 0.01).v_end.x, 1 + 2 * RobotState::ahead, 1e-9);
}

// The trajectory is the model's own where the robot is on it, to the order of the steps.
TEST(RobotState, TheTrajectoryGoesOnAsTheModelDoes) {
  constexpr double h = 0.01;
  for (const Model& model : robots) {
    RobotState state(model);
    const std::vector<double> u(static_cast<std::size_t>(model.nu()), 0.2);
    std::vector<double> x(static_cast<std::size_t>(model.nx()), 0.1);
    ASSERT_TRUE(model.normalise(x.data()));
    const Motion before = state.motion(x.data(), u.data());
    const TrajectoryPoint lead = state.command(x.data(), u.data(), h).lead;
    model.step(x.data(), u.data(), h);
    const Motion after = state.motion(x.data(), u.data());
    EXPECT_LT(norm(lead.p - after.p), 1e-9) << model.name();
    EXPECT_LT(norm(lead.v - after.v), 1e-9) << model.name();
    EXPECT_LT(norm(h * lead.a - (after.v - before.v)), 3e-4) << model.name();
  }
}

TEST(RobotState, TheTrajectoryWaitsForARobotThatDoesNotFollowAndBeginsAnewAfterARest) {
  RobotState state(Multirotor{});
  const std::vector<double> x = {1, 2, 3, 1, 0, 0, 0}, u = {1, 0, 0.5, 1};
  Command c;
  for (int k = 0; k < 1000; ++k) c = state.command(x.data(), u.data(), 0.01);
  EXPECT_NEAR(norm(c.lead.p - Vec3<double>{1, 2, 3}), RobotState::lead_p, 1e-9);
  EXPECT_GT(c.lead.p.x, 1.2);  // ahead of it, in its heading
  EXPECT_LE(norm(c.lead.v.x, c.lead.v.y), RobotState::lead_v + 1e-9);
  EXPECT_NEAR(std::atan2(c.lead.d.y, c.lead.d.x), RobotState::lead_d, 1e-9);
  state.rest();
  EXPECT_LT(norm(state.command(x.data(), u.data(), 0.01).lead.p - Vec3<double>{1, 2, 3}), 0.01);
}

}  // namespace
}  // namespace sightline::dds
