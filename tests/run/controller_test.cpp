#include "sightline/run/controller.hpp"

#include <gtest/gtest.h>

#include "sightline/loop.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/event_team.hpp"
#include "tests/support/valid.hpp"

namespace sightline {
namespace {

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
