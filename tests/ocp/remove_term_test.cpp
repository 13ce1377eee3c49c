#include "sightline/ocp/event/remove_term.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/ocp/roster.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(RemoveTerm, FadesAwayAndFreesItsName) {
  Roster roster(event_team(2));
  EXPECT_THAT(roster.apply(RemoveTerm{"off1"}, 1.0, 2.0), IsEmpty());
  EXPECT_FALSE(roster.has_term("off1"));
  EXPECT_EQ(roster.team(2.0).couplings().size(), 3U) << "it fades";
  EXPECT_EQ(roster.team(3.0).couplings().size(), 2U);
}

TEST(RemoveTerm, IsSaid) {
  const Team team = event_team(2);
  EXPECT_EQ(RemoveTerm{"off1"}.words(team), "remove off1");
}

}  // namespace
}  // namespace sightline
