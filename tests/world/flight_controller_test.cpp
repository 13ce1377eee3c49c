#include "sightline/world/flight_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/wrench.hpp"

namespace sightline {
namespace {

using test::RotorWrench;

RigidBody body_of(const Vehicle& v) { return {.mass = v.mass, .inertia = v.inertia, .p = {0, 0, 1}}; }
Quaternion turned(const Vec3<double>& axis, double angle) {
  const double s = std::sin(0.5 * angle);
  return {std::cos(0.5 * angle), s * axis.x, s * axis.y, s * axis.z};
}

RotorWrench requested(const Vehicle& v, FlightController& controller, const RigidBody& body,
                      const std::array<double, 4>& u) {
  return test::wrench(v, controller.update(body, rotation(body.q), u));
}

TEST(FlightController, KnowsWhatTheInputsOfEachRobotCommandThatCanFly) {
  EXPECT_EQ(commands_of(Multirotor{}), Commands::tilt);
  EXPECT_EQ(commands_of(AngleMultirotor{}), Commands::tilt);
  EXPECT_EQ(commands_of(HoverMultirotor{}), Commands::tilt);
  EXPECT_EQ(commands_of(LaggingHoverMultirotor{}), Commands::tilt);
  EXPECT_EQ(commands_of(VelocityMultirotor{}), Commands::velocity);
  EXPECT_EQ(commands_of(LaggedMultirotor<Lags::plane>{}), Commands::velocity);
  EXPECT_EQ(commands_of(OmniRover{}), std::nullopt);
  EXPECT_EQ(commands_of(Unicycle{}), std::nullopt);
  EXPECT_EQ(commands_of(PointMass{}), Commands::full_state);
}

TEST(FlightController, AtRestAndWithoutCommandItAsksForTheWeightAndNoTorque) {
  for (const auto& preset : Vehicle::presets()) {
    for (const Commands commands : {Commands::tilt, Commands::velocity, Commands::full_state}) {
      FlightController controller(preset.part, commands);
      const RotorWrench w = requested(preset.part, controller, body_of(preset.part), {});
      EXPECT_NEAR(w.thrust, preset.part.weight(), 1e-12);
      EXPECT_LT(norm(w.torque), 1e-12);
    }
  }
}

// u_f > 0 pitches forward (about y), u_s > 0 rolls to the right (about x), in V, whatever the
// heading.
TEST(FlightController, TiltCommandsTiltForwardAndToTheRightInTheHeadingFrame) {
  const Vehicle v = Vehicle::x500();
  for (double psi = -3.0; psi < 3.1; psi += 0.5) {
    RigidBody body = body_of(v);
    body.q = turned({0, 0, 1}, psi);
    FlightController controller(v, Commands::tilt);
    const RotorWrench forward = requested(v, controller, body, {0.1, 0, 0, 0});
    EXPECT_GT(forward.torque.y, 0.0);
    EXPECT_NEAR(forward.torque.x, 0.0, 1e-12);
    controller.begin();
    const RotorWrench right = requested(v, controller, body, {0, 0.1, 0, 0});
    EXPECT_GT(right.torque.x, 0.0);
    EXPECT_NEAR(right.torque.y, 0.0, 1e-12);
    controller.begin();
    const RotorWrench turn = requested(v, controller, body, {0, 0, 0, 0.1});
    EXPECT_GT(turn.torque.z, 0.0);
    controller.begin();
    EXPECT_GT(requested(v, controller, body, {0, 0, 0.1, 0}).thrust, v.weight());
  }
}

TEST(FlightController, AsksForNoTiltTorqueAtTheTiltThatIsCommanded) {
  const Vehicle v = Vehicle::x500();
  RigidBody body = body_of(v);
  body.q = turned({0, 1, 0}, 0.5 * v.tilt_max);
  FlightController controller(v, Commands::tilt);
  const RotorWrench w = requested(v, controller, body, {0.5, 0, 0, 0});
  EXPECT_LT(norm(w.torque), 1e-12);
  // The collective makes up for the tilt.
  EXPECT_NEAR(w.thrust * std::cos(0.5 * v.tilt_max), v.weight(), 1e-12);
}

TEST(FlightController, VelocityCommandsLeanTowardsTheVelocityThatIsMissing) {
  const Vehicle v = Vehicle::x500();
  RigidBody body = body_of(v);
  body.q = turned({0, 0, 1}, std::numbers::pi / 2);  // heads along y of G
  FlightController controller(v, Commands::velocity);
  EXPECT_GT(requested(v, controller, body, {0.5, 0, 0, 0}).torque.y, 0.0);
  controller.begin();
  EXPECT_LT(requested(v, controller, body, {0, 0.5, 0, 0}).torque.x, 0.0);  // to the left
  controller.begin();
  body.v = {0, 0.5, 0};
  EXPECT_LT(norm(requested(v, controller, body, {0.5, 0, 0, 0}).torque), 1e-12);
}

TEST(FlightController, NeverAsksForMoreTiltThanTheLimitUnderVelocityCommands) {
  const Vehicle v = Vehicle::x500();
  RigidBody body = body_of(v);
  body.q = turned({0, 1, 0}, v.tilt_limit);
  FlightController controller(v, Commands::velocity);
  // Held there by an error of 50 m/s, with no torque asked for beyond.
  for (int k = 0; k < 1000; ++k) {
    const RotorWrench w = requested(v, controller, body, {50, 0, 0, 0});
    EXPECT_NEAR(w.torque.y, 0.0, 1e-9);
  }
}

TEST(FlightController, FullStateCommandsAskForTheirAccelerationAtOnceAndForTheWayToTheirTrajectory) {
  const Vehicle v = Vehicle::x500();
  FlightController controller(v, Commands::full_state);
  EXPECT_NEAR(requested(v, controller, body_of(v), {0, 0, 1.0, 0}).thrust, v.mass * (gravity + 1.0), 0.1);
  controller.begin();
  EXPECT_GT(requested(v, controller, body_of(v), {1.0, 0, 0, 0}).torque.y, 0.0);
  controller.begin();
  requested(v, controller, body_of(v), {});  // its trajectory rests here
  RigidBody moved = body_of(v);
  moved.p = moved.p + Vec3<double>{0, 0.2, 0};
  EXPECT_GT(requested(v, controller, moved, {}).torque.x, 0.0) << "back, to the right";
  controller.begin();
  moved.q = turned({0, 0, 1}, 0.3);
  EXPECT_LT(requested(v, controller, moved, {}).torque.z, 0.0) << "heads along x";
}

TEST(FlightController, TheTrajectoryOfFullStateCommandsWaitsForABodyThatCannotFollow) {
  const Vehicle v = Vehicle::x500();
  FlightController controller(v, Commands::full_state);
  for (int k = 0; k < 500; ++k)
    requested(v, controller, body_of(v), {8.0, 0, 0, 0});  // held for 1 s: 4 m, 8 m/s
  const double lean = requested(v, controller, body_of(v), {}).torque.y;
  controller.begin();
  EXPECT_GT(lean, requested(v, controller, body_of(v), {2.0, 0, 0, 0}).torque.y);
  controller.begin();
  EXPECT_LT(lean, requested(v, controller, body_of(v), {3.5, 0, 0, 0}).torque.y);
}

TEST(FlightController, IsFiniteForAnyFiniteBodyAndCommand) {
  const Vehicle v = Vehicle::crazyflie();
  for (const Commands commands : {Commands::tilt, Commands::velocity, Commands::full_state}) {
    FlightController controller(v, commands);
    for (const double angle : {0.0, 1.0, std::numbers::pi / 2, std::numbers::pi}) {
      RigidBody body = body_of(v);
      body.q = turned({0, 1, 0}, angle);
      body.w = {30, -20, 10};
      for (const double u : {-1e6, 0.0, 1e6}) {
        const Thrusts f = controller.update(body, rotation(body.q), {u, -u, u, u});
        for (const double one : f) EXPECT_TRUE(std::isfinite(one) && one >= 0);
      }
    }
  }
}

}  // namespace
}  // namespace sightline
