// The world of vehicles under the loop's promises: nothing is allocated in flight.
#include <gtest/gtest.h>

#include <vector>

#include "sightline/robots.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/counted_new.hpp"

namespace sightline {
namespace {

TEST(RotorWorldLoop, MeasuringAndApplyingAllocateNothingToTheEndOfTheWorld) {
  Team team;
  team.add(Multirotor{}, {.name = "uav"});
  team.add(VelocityMultirotor{}, {.name = "scout"});
  team.add(Obstacle{.name = "target"});
  const std::vector<double> x0 = {0, 0, 2, 1, 0, 0, 0, 3, 0, 2, 1, 0, 0, 0, 0, 0, 9, 0, 1, 0.1, 0, 0};
  RotorWorld world(std::move(team), x0,
                   {{BodyId{0}, Vehicle::x500(), "x500"}, {BodyId{1}, Vehicle::crazyflie(), "crazyflie"}},
                   {.disturbances = {.wind = {0.3, 0, 0},
                                     .gust_sigma = 0.2,
                                     .airflow = {.amplitude = 0.1},
                                     .input_delay = 0.03,
                                     .yaw_lag = 0.1}},
                   {.noise = {.position = 0.01}, .delay = 0.02});
  const std::vector<double> u = {0.1, -0.2, -1.0, 0.4, 0.4, 0.3, 0.2, 0.3};
  bool goes_on = true;
  int periods = 0;
  test::AnyCommand command(world.team());
  const std::int64_t before = allocations_here();
  for (; goes_on && periods < 1000; ++periods) {
    const Measured seen = world.measure(0.01 * periods);
    goes_on = world.apply(0.01 * periods, seen.measured, command(u), 0.01, 1);
  }
  EXPECT_EQ(allocations_here(), before);
  EXPECT_FALSE(goes_on);
  EXPECT_GT(periods, 100);
  EXPECT_NE(world.ended(), "");
}

}  // namespace
}  // namespace sightline
