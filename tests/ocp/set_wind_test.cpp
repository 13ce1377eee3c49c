#include "sightline/ocp/event/set_wind.hpp"

#include <gtest/gtest.h>

#include "sightline/ocp/event.hpp"
#include "sightline/ocp/roster.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

TEST(SetWind, TheLastWindCountsAndIsOfTheWorld) {
  Roster roster(event_team(1));
  EXPECT_FALSE(roster.membership().around.wind.has_value());
  EXPECT_EQ(roster.apply(SetWind{{1, 0, 0}}, 2.0, 0.5), "");
  EXPECT_EQ(roster.apply(SetWind{{0, 2, 0}}, 3.0, 1.0), "");
  const auto wind = roster.membership().around.wind;
  ASSERT_TRUE(wind.has_value());
  EXPECT_EQ(wind->acceleration.y, 2.0);
  EXPECT_EQ(wind->begin, 3.0);
  EXPECT_TRUE(changes_surroundings({.events = {{.name = "", .trigger = AtTime{}, .actions = {SetWind{}}}}}));
  EXPECT_FALSE(
      changes_surroundings({.events = {{.name = "", .trigger = AtTime{}, .actions = {RemoveTerm{"x"}}}}}));
}

}  // namespace
}  // namespace sightline
