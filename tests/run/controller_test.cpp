#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "sightline/loop.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/event_team.hpp"
#include "tests/support/valid.hpp"

namespace sightline {
namespace {

TEST(Controller, ARobotThatItsTeamSeesAsAnObstacleIsGivenAsPlaceAndVelocity) {
  const Team world = event_team(3);
  ActiveTeam active_team(world);
  ASSERT_EQ(active_team.apply(RemoveBody{BodyId{1}, Afterwards::hold}, 0.0, 0.0), "");
  NewtonRiccati solver(active_team.team(0.0), Horizon{});
  Controller controller(world, solver, 0);
  const std::vector<double> x = event_start(world), u(static_cast<std::size_t>(world.nu()), 0.5);
  controller.gather(world, test::valid(world, x), u);
  const Team& team = solver.ocp().team();
  ASSERT_EQ(controller.states.size(), static_cast<std::size_t>(team.nx()));
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i}, real = world.find(team.name(body));
    const Sight<double> seen = team.model(body).sight(
        &controller.states[static_cast<std::size_t>(team.state_offset(body))], u.data());
    const Sight<double> is = world.model(real).sight(&x[static_cast<std::size_t>(world.state_offset(real))],
                                                     &u[static_cast<std::size_t>(world.input_offset(real))]);
    EXPECT_EQ(norm(seen.p - is.p), 0.0);
    EXPECT_LT(norm(seen.v - is.v), 1e-12);
  }
}

TEST(UncontrolledRobot, HoldsOrSinksToTheGroundAndStaysThere) {
  for (const bool lands : {false, true}) {
    const Team world = event_team(2);
    std::vector<double> x = event_start(world);
    x[5] = 1.2, x[6] = -0.7;  // flies fast when it is left alone
    Plant plant(world, x);
    UncontrolledRobot robot(world, BodyId{0}, lands, 0.01);
    std::vector<double> u(static_cast<std::size_t>(world.nu())), low(4), high(4);
    for (int k = 0; k < 1500; ++k) {
      robot.steer(0.01 * k, test::valid(world, plant.x()), std::vector<double>(u.size()), low, high, u);
      for (const double input : std::span(u).first(4)) EXPECT_LE(std::abs(input), 1.0);
      ASSERT_TRUE(plant.step(u, 0.01));
    }
    const Sight<double> there = world.model(BodyId{0}).sight(plant.x().data(), u.data());
    EXPECT_LT(norm(there.v), 0.01);
    EXPECT_NEAR(there.p.z, lands ? 0.0 : 1.0, lands ? 0.02 : 0.3);
  }
}

TEST(UncontrolledRobot, BrakesWithinTheLimitsThatWhatIsAddedLeaves) {
  const Team world = event_team(2);
  std::vector<double> x = event_start(world);
  x[5] = 3.0;
  UncontrolledRobot robot(world, BodyId{0}, false, 0.01);
  std::vector<double> u(static_cast<std::size_t>(world.nu())), added(u.size()), low(4), high(4);
  for (const double by : {0.0, 0.5, -0.5}) {
    added[0] = by;
    for (int k = 0; k < 300; ++k) robot.steer(0.01 * k, test::valid(world, x), added, low, high, u);
    EXPECT_NEAR(u[0] + by, -1.0, 1e-12);
  }
}

}  // namespace
}  // namespace sightline
