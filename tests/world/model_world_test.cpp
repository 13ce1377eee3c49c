#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/copied.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using test::copied;
using test::two_robots;
using test::two_robots_start;
using Numbers = std::vector<double>;

const Numbers input_of_both = {0.3, -0.2, 0.1, 0.4, -0.1, 0.2, 0.3, -0.4};

TEST(ModelWorld, IsItsPlantSeenByItsSensorBitForBit) {
  const PlantOptions in_wind{.seed = 3, .disturbances = {.wind = {0.3, 0, 0}, .gust_sigma = 0.2}};
  const SensorOptions late{.seed = 3, .noise = {.position = 0.01}, .delay = 0.03};
  ModelWorld world(two_robots(), two_robots_start, in_wind, late);
  Plant plant(two_robots(), two_robots_start, in_wind);
  Sensor sensor(two_robots(), late);
  for (int k = 0; k < 200; ++k) {
    const double t = 0.01 * k;
    const Measured seen = world.measure(t);
    EXPECT_EQ(copied(seen.truth), copied(plant.x()));
    EXPECT_EQ(copied(seen.measured), copied(sensor.measure(t, plant.x())));
    EXPECT_EQ(copied(seen.stamps), copied(sensor.stamps()));
    EXPECT_TRUE(seen.detections.empty());
    ASSERT_TRUE(test::apply(world, t, seen.measured, input_of_both, 0.01, 1));
    plant.step(input_of_both, 0.01);
  }
}

TEST(ModelWorld, PeriodsThatWereMissedPassUnderTheInputsThatWentOn) {
  ModelWorld at_once(two_robots(), two_robots_start), one_by_one(two_robots(), two_robots_start);
  ASSERT_TRUE(test::apply(at_once, 0.0, {}, input_of_both, 0.01, 25));
  for (int k = 0; k < 25; ++k) ASSERT_TRUE(test::apply(one_by_one, 0.01 * k, {}, input_of_both, 0.01, 1));
  EXPECT_EQ(copied(at_once.measure(0.25).truth), copied(one_by_one.measure(0.25).truth));
}

TEST(ModelWorld, WhoJoinsBeginsAtTheStartAndIsSeenThereAtOnceThoughMeasurementsAreLate) {
  ModelWorld world(two_robots(), two_robots_start, {}, {.delay = 0.2});
  world.set_presence(std::array{Presence::steered, Presence::absent});
  for (int k = 0; k < 100; ++k) {
    (void)world.measure(0.01 * k);
    ASSERT_TRUE(test::apply(world, 0.01 * k, {}, input_of_both, 0.01, 1));
  }
  world.set_presence(std::array{Presence::steered, Presence::steered});
  const Measured seen = world.measure(1.0);
  const auto b = [](std::span<const double> x) { return copied(x.subspan(7, 7)); };
  EXPECT_EQ(b(seen.measured), b(world.start()));
  EXPECT_EQ(b(seen.truth), b(world.start()));
  EXPECT_NE(copied(seen.measured.first(7)), copied(world.start().first(7)));
}

TEST(ModelWorld, AStateThatIsNoLongerFiniteEndsTheWorld) {
  ModelWorld world(two_robots(), two_robots_start);
  Numbers spoilt = input_of_both;
  spoilt[2] = std::numeric_limits<double>::max();
  EXPECT_FALSE(test::apply(world, 0.0, {}, spoilt, 0.01, 1));
}

}  // namespace
}  // namespace sightline
