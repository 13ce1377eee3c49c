#include "bridges/dds/simulators/simulated_body.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline::dds {
namespace {

const std::vector<std::optional<Vehicle>> bodies = {std::nullopt, Vehicle::crazyflie(), Vehicle::x500()};

TEST(SimulatedBody, TakesOffFollowsAVelocityTurnsAndStandsWhereItLanded) {
  for (const auto& rotors : bodies) {
    SimulatedBody body({1, 2, 0}, 0.5, rotors);
    body.rest();
    EXPECT_TRUE(body.on_ground());
    EXPECT_EQ(norm(body.motion().v), 0.0);
    for (int k = 0; k < 300; ++k) body.follow({0, 0, 0.5}, {}, 0.0);
    EXPECT_NEAR(body.motion().p.z, 1.4, 0.15);
    for (int k = 0; k < 600; ++k) body.follow({0.3, -0.4, 0}, {}, 0.6);
    const Motion& m = body.motion();
    EXPECT_NEAR(m.v.x, 0.3, 0.05);
    EXPECT_NEAR(m.v.y, -0.4, 0.05);
    EXPECT_NEAR(m.v.z, 0.0, 0.05);
    EXPECT_NEAR(m.r, 0.6, 0.05);
    for (int k = 0; k < 800 && !body.on_ground(); ++k) body.follow({0, 0, -0.3}, {}, 0.0);
    EXPECT_TRUE(body.on_ground());
  }
}

// v = v_sp (1 - exp(-t / 0.3)), and the place is its integral; likewise the heading.
TEST(SimulatedBody, ThePointFollowsWithTheLagsThatAreGiven) {
  SimulatedBody body({0, 0, 5}, 0.0, std::nullopt);
  for (int k = 0; k < 40; ++k) body.follow({0.5, 0, 0}, {}, 0.6);
  const double t = 0.4, gone = 1 - std::exp(-t / 0.3), turned = 1 - std::exp(-t / 0.1);
  EXPECT_NEAR(body.motion().v.x, 0.5 * gone, 1e-12);
  EXPECT_NEAR(body.motion().p.x, 0.5 * (t - 0.3 * gone), 1e-12);
  EXPECT_NEAR(body.motion().r, 0.6 * turned, 1e-12);
  const Vec2<double> d = heading(rotation(body.motion().q));
  EXPECT_NEAR(std::atan2(d.y, d.x), 0.6 * (t - 0.1 * turned), 1e-12);
}

TEST(SimulatedBody, ComesUpToItsAltitudeAndDownToTheGround) {
  EXPECT_EQ(takeoff_speed(0.0, 5.0), 1.5);
  EXPECT_EQ(takeoff_speed(5.5, 5.0), 0.0);
  EXPECT_EQ(landing_speed(1.0), -0.7);
  SimulatedBody body({}, 0.0, std::nullopt);
  for (int k = 0; k < 300; ++k) body.follow({0, 0, takeoff_speed(body.motion().p.z, 1.0)}, {}, 0.0);
  EXPECT_NEAR(body.motion().p.z, 1.0, 0.1);
  for (int k = 0; k < 200; ++k) body.follow({0, 0, landing_speed(body.motion().p.z)}, {}, 0.0);
  EXPECT_TRUE(body.on_ground());
}

// p = g t^2 / 2, then still.
TEST(SimulatedBody, WithMotorsOffItFalls) {
  for (const auto& rotors : bodies) {
    SimulatedBody body({}, 0.0, rotors);
    for (int k = 0; k < 400; ++k) body.follow({0, 0, 0.5}, {}, 0.0);
    for (int k = 0; k < 200; ++k) body.follow({}, {}, 0.0);
    const double height = body.motion().p.z;
    for (int k = 0; k < 30; ++k) body.rest();
    EXPECT_NEAR(height - body.motion().p.z, 0.5 * gravity * 0.09, 0.06);
    for (int k = 0; k < 100; ++k) body.rest();
    EXPECT_TRUE(body.on_ground());
    EXPECT_EQ(norm(body.motion().v), 0.0);
  }
}

// Half of the commands that tilt it forward is half of the tilt: g tan(tilt) less drag.
TEST(SimulatedBody, TiltsAsTheInputsSay) {
  SimulatedBody body({}, 0.0, Vehicle::ar_drone(), Commands::tilt);
  for (int k = 0; k < 200; ++k) body.tilt({0, 0, 0.5, 0});
  for (int k = 0; k < 100; ++k) body.tilt({0.5, 0, 0, 0});
  EXPECT_GT(body.motion().v.x, 0.4);
  EXPECT_NEAR(body.motion().v.y, 0.0, 0.01);
}

}  // namespace
}  // namespace sightline::dds
