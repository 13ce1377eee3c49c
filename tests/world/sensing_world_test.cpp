#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "sightline/worlds.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using test::two_robots;
using testing::ElementsAre;
using testing::IsEmpty;

/// One that shows what sensors are given.
class Shown final : public SensingWorld {
 public:
  using SensingWorld::attitude_of, SensingWorld::sight_of;
  explicit Shown(std::unique_ptr<World> world) : SensingWorld(std::move(world)) {}
};

const std::vector<double> begin = {0, 0, 1, 1, 0, 0, 0, 1.5, 0, 1, 0, 1, 0, 0};

TEST(SensingWorld, AnAttitudeIsWhatTheWorldTellsElseTheModelS) {
  const Shown world(std::make_unique<ModelWorld>(two_robots(), begin));
  const Sight<double> sight = world.sight_of(BodyId{1}, begin);
  EXPECT_EQ(sight.p.x, 1.5);
  Measured now{};
  EXPECT_EQ(world.attitude_of(BodyId{1}, sight, now), leaning(sight.d, sight.lean));
  const std::vector<Quaternion> received = {no_attitude, {0.6, 0.8, 0.0, 0.0}};
  now.attitudes = received;
  EXPECT_EQ(world.attitude_of(BodyId{1}, sight, now), received[1]);
  EXPECT_EQ(world.attitude_of(BodyId{0}, sight, now), leaning(sight.d, sight.lean));
}

struct Letter {
  double arrival = 0.0;
  int number = 0;
};

std::vector<int> numbers(std::span<const Letter> arrived) {
  std::vector<int> all;
  for (const Letter& one : arrived) all.push_back(one.number);
  return all;
}

TEST(UnderWay, ThingsArriveOnceInTheOrderOfArrivalAndThenOfSending) {
  UnderWay<Letter> letters(5);
  for (const Letter& one : {Letter{0.3, 1}, {0.1, 2}, {0.2, 3}, {0.1, 4}, {0.9, 5}}) letters.send(one);
  EXPECT_THAT(numbers(letters.take(0.05)), IsEmpty());
  EXPECT_THAT(numbers(letters.take(0.3)), ElementsAre(2, 4, 3, 1));
  EXPECT_THAT(numbers(letters.take(0.3)), IsEmpty());
  EXPECT_THAT(numbers(letters.take(1.0)), ElementsAre(5));
}

TEST(UnderWay, WhatFindsNoRoomOrIsDroppedNeverArrives) {
  UnderWay<Letter> letters(3);
  for (int i = 0; i < 5; ++i) letters.send({0.1 * i, i});
  letters.drop_if([](const Letter& one) { return one.number == 1; });
  letters.send({0.05, 7});
  EXPECT_THAT(numbers(letters.take(1.0)), ElementsAre(0, 7, 2));
  EXPECT_EQ(letters.capacity(), 3U);
}

}  // namespace
}  // namespace sightline
