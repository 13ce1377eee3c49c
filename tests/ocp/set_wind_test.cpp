#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

TEST(SetWind, TheLastWindCountsAndIsOfTheWorld) {
  ActiveTeam active_team(event_team(1));
  EXPECT_FALSE(active_team.membership().around.wind.has_value());
  EXPECT_EQ(active_team.apply(SetWind{{1, 0, 0}}, 2.0, 0.5), "");
  EXPECT_EQ(active_team.apply(SetWind{{0, 2, 0}}, 3.0, 1.0), "");
  const auto wind = active_team.membership().around.wind;
  ASSERT_TRUE(wind.has_value());
  EXPECT_EQ(wind->acceleration.y, 2.0);
  EXPECT_EQ(wind->begin, 3.0);
  EXPECT_TRUE(changes_surroundings({.events = {{.name = "", .trigger = AtTime{}, .actions = {SetWind{}}}}}));
  EXPECT_FALSE(
      changes_surroundings({.events = {{.name = "", .trigger = AtTime{}, .actions = {RemoveTerm{"x"}}}}}));
}

}  // namespace
}  // namespace sightline
