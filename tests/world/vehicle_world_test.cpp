#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/model.hpp"
#include "sightline/world/fleet.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

class Still final : public Fleet {
 public:
  using Fleet::Fleet;

 private:
  void advance(std::int64_t) noexcept override {}
};

/// Ends by what it is told, and writes down what it is asked.
class Room final : public VehicleWorld {
 public:
  explicit Room(double z = 2.0, const PlantOptions& plant = {})
      : VehicleWorld("room", team_of_two(), {0, 0, z, 1, 0, 0, 0, /**/ 3, 0, 2, 0, 0, 0}, vehicles(),
                     std::make_unique<Still>(team_of_two(), vehicles()), plant, {}) {}
  using VehicleWorld::there;
  using VehicleWorld::Touch;

  std::optional<Touch> next;
  std::vector<double> begun, ended_at;
  std::vector<int> came_in, went;

 private:
  static Team team_of_two() {
    Team team;
    team.add(Multirotor{}, {.name = "uav"});
    team.add(Obstacle{.name = "post"});
    return team;
  }
  static std::vector<RobotVehicle> vehicles() { return {{BodyId{0}, Vehicle::x500()}}; }
  void before(double t) noexcept override { begun.push_back(t); }
  std::optional<Touch> touch(double t) noexcept override {
    ended_at.push_back(t);
    return next;
  }
  void came(BodyId body) noexcept override { came_in.push_back(body.index); }
  void left(BodyId body) noexcept override { went.push_back(body.index); }
};

const std::vector<double> resting(4);

TEST(VehicleWorld, EachPeriodBeginsAndIsLookedAtWhenItHasPassed) {
  Room room;
  EXPECT_TRUE(test::apply(room, 0.0, {}, resting, 0.01, 3));
  EXPECT_THAT(room.begun, testing::Pointwise(testing::DoubleNear(1e-12), {0.0, 0.01, 0.02}));
  EXPECT_THAT(room.ended_at, testing::Pointwise(testing::DoubleNear(1e-12), {0.01, 0.02, 0.03}));
  EXPECT_EQ(room.ended(), "");
}

TEST(VehicleWorld, ATouchEndsItWithASentence) {
  Room room;
  room.next = Room::Touch{.a = BodyId{0}, .b = BodyId{1}, .t = 1.25};
  EXPECT_FALSE(test::apply(room, 0.0, {}, resting, 0.01, 3));
  EXPECT_EQ(room.begun.size(), 1u);
  EXPECT_EQ(room.ended(), "uav and post touched at 1.250 s");
  room.next = Room::Touch{.a = BodyId{0}, .b = BodyId{-1}, .t = 2.0, .speed = 0.75, .surface = "a wall"};
  EXPECT_FALSE(test::apply(room, 0.0, {}, resting, 0.01, 1));
  EXPECT_EQ(room.ended(), "uav touched a wall at 2.000 s with 0.75 m/s, expected at most 0.5 m/s");
}

TEST(VehicleWorld, WhoComesAndWhoLeavesIsToldOnce) {
  Room room;
  using enum Presence;
  room.set_presence(std::array{steered, hold});
  room.set_presence(std::array{steered, absent});
  room.set_presence(std::array{steered, absent});
  EXPECT_FALSE(room.there(BodyId{1}));
  room.set_presence(std::array{steered, hold});
  EXPECT_TRUE(room.there(BodyId{1}));
  EXPECT_EQ(room.came_in, std::vector<int>{1});
  EXPECT_EQ(room.went, std::vector<int>{1});
}

TEST(VehicleWorld, RefusesInTheNameOfItsKind) {
  EXPECT_THAT(refusal_of([] { Room(2.0, {.period = 0.0125}); }),
              HasSubstr("world.kind = \"room\" moves in steps of 0.001 s, but the period is 0.0125 s"));
  EXPECT_THAT(refusal_of([] { Room(-1.0); }), HasSubstr("uav starts at a height of -1 m"));
}

}  // namespace
}  // namespace sightline
