#include "sightline/ocp/event/team_change.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

TEST(TeamChange, AWeightFadesFromWhatIsInForceAndOneAtOnceDoesNotFade) {
  TeamState state;
  const TeamChange slow{state, 3.0, 2.0}, at_once{state, 3.0, 0.0};
  EXPECT_EQ(slow.fading_in(), (Ramp{3.0, 2.0, 0.0, 1.0}));
  EXPECT_EQ(slow.fading_out(Ramp{2.0, 2.0, 0.0, 1.0}), (Ramp{3.0, 2.0, 0.5, 0.0}));
  EXPECT_EQ(at_once.fading_in(), Ramp{});
  EXPECT_EQ(at_once.fading_out(Ramp{}).at(3.0), 0.0);
}

TEST(TeamChange, WhatFadesOutHasNoNameBesideWhatTakesItsPlace) {
  TeamState state;
  state.couplings = event_team(2).couplings();
  const TeamChange change{state, 3.0, 2.0};
  Coupling next = state.couplings[0];
  next.term.weight = 7.0;
  change.replace(state.couplings, 0, next);
  EXPECT_EQ(state.couplings.size(), 4U);
  EXPECT_EQ(state.couplings[0].name, "");
  EXPECT_FALSE(state.couplings[0].ramp.lasts());
  const auto found = change.find(state.couplings, next.name);
  ASSERT_NE(found, state.couplings.end());
  EXPECT_EQ(found->term.weight, 7.0);
  EXPECT_TRUE(state.has_term(next.name));
  EXPECT_FALSE(state.has_term(""));
}

}  // namespace
}  // namespace sightline
