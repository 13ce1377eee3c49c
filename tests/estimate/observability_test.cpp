#include "sightline/estimate/observability.hpp"

#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

const SensingRobot fixed_robot{"anchor", true, true}, lone_robot{"uav1"}, other_robot{"uav2"};
const std::vector<PlacedRobot> spread_places = {{0, 0, 1, 0.3}, {1.5, 0.4, 1.2, 2.0}, {3.0, -0.3, 1.1, -2.5}};

TEST(Observability, TagsThatTellTheirYawLeaveNothingUnknown) {
  EXPECT_TRUE(
      unobservable_states({fixed_robot, lone_robot, other_robot}, spread_places, {{1, 0}, {2, 1}}).empty());
}

TEST(Observability, WithoutYawTheRobotCanTurnAboutWhatItSees) {
  const auto found =
      unobservable_states({fixed_robot, lone_robot}, {spread_places[0], spread_places[1]}, {{1, 0, false}});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].heading && found[0].horizontal);
  EXPECT_FALSE(found[0].height);
  EXPECT_EQ(found[0].about, 0);
  EXPECT_EQ(to_string(found[0], {fixed_robot, lone_robot}),
            "the heading of uav1 is unobservable, and with it its position in the plane: a turn about anchor "
            "changes "
            "nothing that is measured, expected a heading that is measured, by tags or a compass");
}

TEST(Observability, ACompassOrASecondBodyDeterminesIt) {
  const SensingRobot compass{"uav1", false, true};
  EXPECT_TRUE(
      unobservable_states({fixed_robot, compass}, {spread_places[0], spread_places[1]}, {{1, 0, false}})
          .empty());
  EXPECT_TRUE(unobservable_states({fixed_robot, lone_robot, fixed_robot}, spread_places,
                                  {{1, 0, false}, {1, 2, false}})
                  .empty());
}

TEST(Observability, APositionOfItsOwnLeavesTheHeadingUnknown) {
  const SensingRobot gnss{"uav1", true, false};
  auto found = unobservable_states({gnss}, {spread_places[1]}, {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].heading);
  EXPECT_FALSE(found[0].horizontal || found[0].height);
  // What it sees of a body whose place is known tells where it looks.
  EXPECT_TRUE(unobservable_states({fixed_robot, gnss}, {spread_places[0], spread_places[1]}, {{1, 0, false}})
                  .empty());
}

TEST(Observability, WithoutAPathToAnAnchorNothingIsKnown) {
  const auto found =
      unobservable_states({fixed_robot, lone_robot, other_robot}, spread_places, {{1, 2}, {2, 1}});
  ASSERT_EQ(found.size(), 2U);
  for (const Unobservable& what : found) {
    EXPECT_TRUE(what.heading && what.horizontal && what.height);
    EXPECT_EQ(what.about, -1);
  }
  EXPECT_EQ(to_string(found[0], {fixed_robot, lone_robot, other_robot}),
            "the position and heading of uav1 are unobservable: no path of views leads from it to a body "
            "that knows "
            "its place, expected one");
}

TEST(Observability, WhatIsSeenOfARobotTellsItsPlaceToo) {
  // The anchor has the camera: uav1's place is known, and with yaw its heading.
  const auto without =
      unobservable_states({fixed_robot, lone_robot}, {spread_places[0], spread_places[1]}, {{0, 1, false}});
  ASSERT_EQ(without.size(), 1U);
  EXPECT_TRUE(without[0].heading);
  EXPECT_FALSE(without[0].horizontal);
  EXPECT_TRUE(
      unobservable_states({fixed_robot, lone_robot}, {spread_places[0], spread_places[1]}, {{0, 1, true}})
          .empty());
}

TEST(Observability, AnUnknownHeadingIsPassedOn) {
  const auto found = unobservable_states({fixed_robot, lone_robot, other_robot}, spread_places,
                                         {{1, 0, false}, {2, 1, true}});
  ASSERT_EQ(found.size(), 2U) << "uav2 knows its place relative to uav1 alone";
  EXPECT_EQ(found[1].about, -1);
}

TEST(Observability, WhatIsNoRobotIsRefused) {
  EXPECT_EQ(refusal_of([] { (void)unobservable_states({fixed_robot}, {}, {}); }),
            "0 places of 1 robots, expected one of each");
  EXPECT_EQ(refusal_of([] {
              (void)unobservable_states({fixed_robot}, {spread_places[0]}, {{0, 1}});
            }),
            "robot 0 sees robot 1, expected two of 1 robots");
}

}  // namespace
}  // namespace sightline
