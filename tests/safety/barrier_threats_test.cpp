// Which neighbours a Barrier reckons with, and by which plans.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/support/adversary.hpp"

namespace sightline {
namespace {

using test::highest;
using test::lowest;
using test::State;
using test::VehicleInput;

TEST(BarrierThreats, LetsAnUncooperativeOneNearerWhoseVelocityIsKnown) {
  const Barrier filter = test::barrier();
  const State x = {0, 0, 1, 1, 0, 0, 0};
  Neighbour n{.p = {3, 0, 1}};
  const double unknown = filter.reserve(x, n);
  n.v = {0.5, 0, 0};
  EXPECT_EQ(filter.reserve(x, n), unknown);
  n.acceleration_max = 0.1;
  EXPECT_GT(filter.reserve(x, n), unknown + 0.5);
  n.acceleration_max = 50.0;
  EXPECT_EQ(filter.reserve(x, n), unknown);
}

TEST(BarrierThreats, TwoOfWhomOneHasLessLeftReckonWithTheLess) {
  const Barrier filter = test::barrier();
  const State x = {0, 0, 1, 1, 0, 1.0, 0};
  Neighbour other{.p = {3, 0, 1}, .v = {-1, 0, 0}, .d_hard = 0.6, .behavior = Behavior::cooperative};
  const double both = filter.reserve(x, other);
  other.part = 0.5;
  EXPECT_LT(filter.reserve(x, other), both - 0.05);
}

// One of them may move at will, with what is known of its motion or without.
TEST(BarrierThreats, OfSeveralTheLeastReserveCountsInWhateverOrderTheyAreTold) {
  const Barrier filter = test::barrier();
  Random random(7);
  const State x = {0, 0, 1, 1, 0, 0.5, 0};
  for (int k = 0; k < 200; ++k) {
    std::vector<Neighbour> all;
    const std::size_t count = 2 + random() % 11;
    for (std::size_t i = 0; i < count; ++i) {
      Neighbour n{.p = Vec3<double>{0, 0, 1} + uniform(random, 1.5, 4.0) * test::any_direction(random, true),
                  .v = {uniform(random, -1, 1), uniform(random, -1, 1), 0},
                  .d_hard = 0.6,
                  .behavior = Behavior::cooperative};
      if (i == 0) n.behavior = Behavior::uncooperative;
      if (i == 0 && k % 2 == 0) n.acceleration_max = 0.2;
      all.push_back(n);
    }
    double least = 1e9;
    for (const Neighbour& n : all) least = std::min(least, filter.reserve(x, n));
    VehicleInput first = test::towards(x, all.back().p), second = first;
    const BarrierResult reported = filter.filter(x, all, lowest, highest, first);
    EXPECT_EQ(reported.reserve, least);
    std::rotate(all.begin(), all.begin() + 1, all.end());
    EXPECT_EQ(filter.filter(x, all, lowest, highest, second).reserve, least);
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(first[i], second[i], 1e-6);
  }
}

TEST(BarrierThreats, AMemberThatCannotComeTooNearChangesNothing) {
  const Barrier filter = test::barrier();
  Random random(8);
  const State x = {0, 0, 1, 1, 0, 1.0, 0};
  for (int k = 0; k < 200; ++k) {
    const Neighbour near{.p = {uniform(random, 1.0, 2.0), uniform(random, -0.5, 0.5), 1},
                         .v = {-1, 0, 0},
                         .d_hard = 0.6,
                         .behavior = Behavior::cooperative};
    Neighbour far = near;
    far.p = Vec3<double>{0, 0, 1} + uniform(random, 15, 30) * test::any_direction(random, true);
    const std::vector<Neighbour> both = {far, near};
    VehicleInput alone = {1, 0, 0, 0}, u = alone;
    const BarrierResult one = filter.filter(x, {&near, 1}, lowest, highest, alone);
    const BarrierResult two = filter.filter(x, both, lowest, highest, u);
    EXPECT_EQ(u, alone);
    EXPECT_EQ(two.reserve, one.reserve);
  }
}

}  // namespace
}  // namespace sightline
