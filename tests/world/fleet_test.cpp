#include "sightline/world/fleet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "sightline/robots.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

/// Writes down what it is asked to move.
class Written final : public Fleet {
 public:
  using Fleet::Fleet;
  std::vector<std::int64_t> steps;
  std::vector<std::size_t> steered;
  std::vector<std::int64_t> ticks;
  Vec3<double> air(std::size_t i) const { return crafts_[i].air; }
  std::array<double, 4> commands(std::size_t i) const { return crafts_[i].commands; }

 private:
  void advance(std::int64_t n) noexcept override {
    steps.push_back(n);
    ticks.push_back(tick());
    steered.push_back(static_cast<std::size_t>(
        std::count_if(crafts_.begin(), crafts_.end(), [](const Craft& craft) { return craft.steered; })));
  }
};

Team three() {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  team.add(VelocityMultirotor{}, {.name = "b"});
  team.add(OmniRover{}, {.name = "rover"});
  return team;
}
const std::vector<RobotVehicle> two = {{BodyId{0}, Vehicle::x500()}, {BodyId{1}, Vehicle::crazyflie()}};

TEST(Fleet, ShowsTheStateThatItBegan) {
  Written fleet(three(), two);
  const std::vector<double> x = {1, 2, 3, 0.6, 0.8, 0.5, -0.2, 0.1, 0.4};
  for (const auto& [robot, n] : {std::pair{BodyId{0}, 7u}, std::pair{BodyId{1}, 9u}}) {
    std::vector<double> shown(n, -1.0);
    fleet.begin(robot, 0.0, x.data());
    fleet.show(robot, shown.data());
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(shown[i], x[i], 1e-15) << i;
  }
}

TEST(Fleet, StepsAreWholeMillisecondsSinceTheStartAndMoveThoseThatWereSteered) {
  Written fleet(three(), two);
  const std::array<double, 4> u = {0.1, 0.2, 0.3, 0.4};
  fleet.steer(BodyId{1}, u.data(), {0.5, 0, 0});
  fleet.move(0.0104);
  fleet.steer(BodyId{0}, u.data(), {});
  fleet.steer(BodyId{1}, u.data(), {});
  fleet.move(0.0104);
  fleet.move(0.02);
  EXPECT_EQ(fleet.steps, (std::vector<std::int64_t>{10, 10}));
  EXPECT_EQ(fleet.ticks, (std::vector<std::int64_t>{0, 10}));
  EXPECT_EQ(fleet.steered, (std::vector<std::size_t>{1, 0})) << "a robot is steered for one move";
  EXPECT_EQ(fleet.commands(1), u);
}

TEST(Fleet, MovesItsVehiclesAlone) {
  const Written fleet(three(), two);
  EXPECT_TRUE(fleet.moves(BodyId{0}) && fleet.moves(BodyId{1}));
  EXPECT_FALSE(fleet.moves(BodyId{2}) || fleet.moves(BodyId{-1}) || fleet.moves(BodyId{9}));
  EXPECT_EQ(fleet.rotorcraft(BodyId{1})->vehicle().mass, Vehicle::crazyflie().mass);
}

TEST(Fleet, RefusesARobotThatIsNoVehicleOrTwo) {
  const auto refused = [](const std::vector<RobotVehicle>& vehicles) {
    return refusal_of([&] { Written(three(), vehicles); });
  };
  EXPECT_THAT(refused({{BodyId{2}, Vehicle::x500()}}), HasSubstr("expected one that a vehicle can be"));
  EXPECT_THAT(refused({{BodyId{3}, Vehicle::x500()}}), HasSubstr("expected a robot of the team"));
  EXPECT_THAT(refused({two[0], two[0]}), HasSubstr("a is two vehicles"));
}

}  // namespace
}  // namespace sightline
