#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(RemoveTerm, FadesAwayAndFreesItsName) {
  ActiveTeam active_team(event_team(2));
  EXPECT_THAT(active_team.apply(RemoveTerm{"off1"}, 1.0, 2.0), IsEmpty());
  EXPECT_FALSE(active_team.has_term("off1"));
  EXPECT_EQ(active_team.team(2.0).couplings().size(), 3U) << "it fades";
  EXPECT_EQ(active_team.team(3.0).couplings().size(), 2U);
}

}  // namespace
}  // namespace sightline
