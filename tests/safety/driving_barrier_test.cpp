// The barrier of robots that drive along their heading: the plan, its set, and who is kept away
// from.
#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "cli/allocations.hpp"
#include "sightline/barrier.hpp"
#include "sightline/robots.hpp"
#include "tests/support/driving.hpp"

namespace sightline {
namespace {

using test::DriveInput;
using test::Rover;

TEST(DrivingBarrier, BrakesWithinTheLimitsAndStandsBeforeARock) {
  Random random(1);
  const std::array<double, 2> low = {-1, 0}, high = {1, 0};  // without turns it cannot pass by
  for (int i = 0; i < 300; ++i) {
    const double dt = std::array{0.005, 0.01, 0.1, 0.5}[static_cast<std::size_t>(i % 4)];
    const Unicycle model{.b_psi = 1.5, .a_f = -uniform(random, 0.0, 4.0), .b_f = uniform(random, 0.5, 4.0)};
    const Barrier filter = test::drive_barrier(model, dt);
    const double speed = uniform(random, 0.05, 2.0), towards = i % 3 == 0 ? -1 : 1;
    Rover x = test::rover({0, 0}, uniform(random, -3, 3), towards * speed);
    // The plan just keeps the distance, so that nothing else does.
    const double distance = 0.502 + test::braking_distance(model, speed, dt);
    const Neighbour rock{
        .p = test::at(x) + (distance / speed) * test::velocity(x), .d_hard = 0.5, .speed_max = 0.0};
    EXPECT_NEAR(filter.reserve(x, rock), 0.0, 1e-6) << i;
    const int most = static_cast<int>(std::ceil(test::simulated_brake(model, x, dt).time / dt));
    for (int k = 0; k < most; ++k) {
      DriveInput u = {towards, 0.0};
      EXPECT_FALSE(filter.filter(x, {&rock, 1}, low, high, u).conflict);
      EXPECT_LE(std::abs(u[0]), 0.9 + 1e-5);
      test::drive(model, x, u, dt, [&](const Vec3<double>& p) { EXPECT_GE(norm(p - rock.p), 0.501); });
    }
    EXPECT_NEAR(x[5], 0.0, 1e-5) << i;
    EXPECT_NEAR(norm(test::at(x) - rock.p), 0.502, 1e-5) << i;
  }
}

// The plan and the set are computed here by simulation, of a robot that brakes by its own inputs.
TEST(DrivingBarrier, HasTheReserveThatASimulatedPlanLeaves) {
  Random random(2);
  const Unicycle model;
  const Barrier filter = test::drive_barrier(model, 0.01);
  for (int i = 0; i < 300; ++i) {
    const Rover x = test::rover({0, 0}, uniform(random, -3, 3), uniform(random, -1, 1));
    const Neighbour n{.p = {uniform(random, -2, 2), uniform(random, -2, 2), uniform(random, 0, 1)},
                      .d_hard = 0.4,
                      .speed_max = i % 3 == 0 ? 0.0 : uniform(random, 0, 3),
                      .age = uniform(random, 0, 0.1),
                      .sigma = uniform(random, 0, 0.02)};
    const test::Brake brake = test::simulated_brake(model, x, 0.01);
    double least = infinity;
    for (const Vec3<double>& p : brake.path) least = std::min(least, norm(p - n.p));
    EXPECT_NEAR(filter.reserve(x, n),
                least - n.d_hard - 0.002 - 3 * n.sigma - n.speed_max * (n.age + brake.time), 1e-4)
        << i;
  }
}

TEST(DrivingBarrier, LeavesTheSetAtNoSampleWhateverTheNeighboursDo) {
  const test::OneStep found = test::one_steps(400, 3);
  EXPECT_GE(found.least_reserve, -1e-7);
  EXPECT_GE(found.least_distance, 0.0);
  EXPECT_EQ(found.conflicts, 0);
  EXPECT_GT(found.changed, 100);
}

TEST(DrivingBarrier, StandsBeforeABodyThatMovesAtWillComesNear) {
  Random random(4);
  for (int i = 0; i < 30; ++i) {
    const test::DriveOutcome outcome = test::drive_among(
        {.rovers = 1, .pursuers = 1 + i % 3, .rocks = 0, .duration = 10.0}, static_cast<std::uint64_t>(i));
    EXPECT_LE(outcome.fastest_when_near, 1e-5) << i;
  }
}

TEST(DrivingBarrier, ManyRobotsAndRocksKeepTheirDistanceAtOnce) {
  for (int i = 0; i < 6; ++i) {
    const test::DriveOutcome outcome = test::drive_among(
        {.rovers = 6, .pursuers = 0, .rocks = 4, .duration = 8.0}, static_cast<std::uint64_t>(i));
    EXPECT_GE(outcome.nearest, outcome.d_hard) << i;
    EXPECT_EQ(outcome.conflicts, 0) << i;
    EXPECT_GT(outcome.travelled, 0.5) << i;
    EXPECT_LE(outcome.largest_command, 1.0);
  }
}

TEST(DrivingBarrier, PassesCommandsOfARobotFarFromAllBitForBit) {
  const Barrier filter = test::drive_barrier(Unicycle{}, 0.01);
  const Rover x = test::rover({0, 0}, 0.4, 0.7);
  const Neighbour n{.p = {6, 0, 0.2}, .speed_max = 1.0};
  DriveInput u = {0.3, -0.7};
  const BarrierResult result = filter.filter(x, {&n, 1}, test::drive_low, test::drive_high, u);
  EXPECT_EQ(u, (DriveInput{0.3, -0.7}));
  EXPECT_FALSE(result.active || result.conflict);
}

TEST(DrivingBarrier, StandsStillAndReportsAConflictWhileABodyIsTooNear) {
  const Barrier filter = test::drive_barrier(Unicycle{}, 0.01);
  const Rover x = test::rover({0, 0}, 0.0, 0.0);
  const Neighbour n{.p = {0.5, 0.1, 0.2}, .d_hard = 0.6, .speed_max = 1.0};
  for (const double wanted : {1.0, -1.0}) {
    DriveInput u = {wanted, 0.5};
    const BarrierResult result = filter.filter(x, {&n, 1}, test::drive_low, test::drive_high, u);
    EXPECT_TRUE(result.conflict);
    EXPECT_NEAR(result.violation, -result.reserve, 1e-9);
    EXPECT_EQ(result.neighbour, 0);
    EXPECT_NEAR(u[0], 0.0, 1e-9);
    EXPECT_EQ(u[1], 0.5) << "it may turn";
  }
  // From a body at rest it may drive away.
  const Neighbour rock{.p = n.p, .d_hard = 0.6, .speed_max = 0.0};
  DriveInput u = {-1.0, 0.0};
  (void)filter.filter(x, {&rock, 1}, test::drive_low, test::drive_high, u);
  EXPECT_EQ(u[0], -1.0);
}

TEST(DrivingBarrier, StopsBeforeBoundsAndZones) {
  Random random(5);
  BarrierOptions options;
  options.world = 3.0;
  options.zones = {{.polygon = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}, .to = 2.0}};
  const Barrier filter = test::drive_barrier(Unicycle{}, 0.01, options);
  double travelled = 0.0;
  for (int i = 0; i < 12; ++i) {
    const double beside = uniform(random, -2, 2), heading = uniform(random, -3, 3);
    Rover x = test::rover({2.0, beside}, heading, 0.0);
    DriveInput wanted{};
    for (int k = 0; k < 2000; ++k) {
      if (k % 100 == 0) wanted = {k % 200 == 0 ? 1.0 : uniform(random, -1, 1), uniform(random, -1, 1)};
      DriveInput u = wanted;
      EXPECT_FALSE(filter.filter(x, {}, test::drive_low, test::drive_high, u).conflict) << i << " at " << k;
      test::drive(Unicycle{}, x, u, 0.01, [&](const Vec3<double>& p) {
        EXPECT_LE(std::max(std::abs(p.x), std::abs(p.y)), 3.0);
        EXPECT_GE(std::max(std::abs(p.x), std::abs(p.y)), 0.5);
      });
      travelled += 0.01 * std::abs(x[5]);
    }
  }
  EXPECT_GT(travelled, 12 * 3.0);
}

TEST(DrivingBarrier, AllocatesNothing) {
  if (!cli::counts_allocations()) return;
  const Barrier filter = test::drive_barrier(Unicycle{}, 0.1);
  std::vector<Neighbour> all;
  for (int i = 0; i < 200; ++i)
    all.push_back({.p = {1.2 + 0.001 * i, 0, 0.2}, .speed_max = i % 2 == 0 ? 0.0 : 1.0});
  const Rover x = test::rover({0, 0}, 0.0, 1.0);
  for (const std::size_t count : {1U, 20U, 200U}) {
    DriveInput u = {1, 1};
    const std::int64_t before = cli::allocations();
    (void)filter.filter(x, std::span(all).first(count), test::drive_low, test::drive_high, u);
    EXPECT_EQ(cli::allocations(), before);
    EXPECT_LT(u[0], 0.0);
  }
}

TEST(DrivingBarrier, AHostOfNearRobotsMakesItBrake) {
  const Barrier filter = test::drive_barrier(Unicycle{}, 0.01, {.world = 3.0});
  std::vector<Neighbour> all(300, Neighbour{.p = {1.0, 0, 0.2}, .d_hard = 0.6, .speed_max = 0.0});
  const Rover x = test::rover({0, 0}, 0.0, 0.9);
  DriveInput u = {1, 1};
  (void)filter.filter(x, all, test::drive_low, test::drive_high, u);
  EXPECT_NEAR(u[0], -0.9, 1e-6);
  EXPECT_EQ(u[1], 0.0);
}

}  // namespace
}  // namespace sightline
