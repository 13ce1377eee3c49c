#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

TEST(EventInstant, WithoutPresenceAllAreThereAndWithoutAgesAllIsNew) {
  const Team team = event_team(2);
  const std::vector<double> x = event_start(team), u(8);
  ConditionState state;
  const std::vector<Presence> presence = {Presence::hold, Presence::absent};
  const std::vector<double> ages = {0.5, 2.0};
  const EventContext plain{.t = 1.0, .x = x, .u = u, .ages = {}, .presence = {}},
      known{1.0, x, u, ages, presence};
  const EventInstant all{team, plain, 0.0, false, state}, some{team, known, 0.0, false, state};
  EXPECT_TRUE(all.is_there(BodyId{1}) && all.is_steered(BodyId{1}));
  EXPECT_EQ(all.age(BodyId{1}), 0.0);
  EXPECT_TRUE(some.is_there(BodyId{0}));
  EXPECT_FALSE(some.is_steered(BodyId{0}) || some.is_there(BodyId{1}));
  EXPECT_EQ(some.age(BodyId{1}), 2.0);
  EXPECT_EQ(some.sight(BodyId{1}).p.x, x[7]);
}

}  // namespace
}  // namespace sightline
