#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> faults(std::vector<TeamEvent> events, std::vector<Presence> presence = {}) {
  std::vector<std::string> sentences;
  for (const ScriptFault& fault :
       faults_of({std::move(events)}, ActiveTeam(event_team(4, 2), std::move(presence)))) {
    sentences.push_back(fmt::format("{}: {}", fault.event, fault.sentence));
  }
  return sentences;
}

TeamEvent at(double t, Action action) {
  return {.name = "", .trigger = AtTime{t}, .actions = {std::move(action)}};
}
Condition near(double below, double hysteresis = 0.0, double dwell = 0.0) {
  return {DistanceOf{BodyId{0}, BodyId{1}}, Condition::Side::below, below, hysteresis, dwell};
}
TeamEvent goes(std::string stage, Trigger trigger, std::string enter) {
  return {.name = "", .trigger = std::move(trigger), .stage = std::move(stage), .enter = std::move(enter)};
}

TEST(Script, AWeightRampsForASecondWhereAnObserverChangesItsTarget) {
  TeamEvent event = at(1.0, RemoveTerm{"sees2"});
  EXPECT_EQ(ramp_of(event), 0.0);
  event.actions.push_back(Observe{AgentId{BodyId{3}}, BodyId{0}});
  EXPECT_EQ(ramp_of(event), 1.0);
  event.ramp = 0.25;
  EXPECT_EQ(ramp_of(event), 0.25);
}

TEST(Script, OneThatCanBeFlownHasNoFault) {
  EXPECT_THAT(faults({at(5.0, RemoveBody{BodyId{3}}), at(9.0, AddBody{BodyId{3}}),
                      at(12.0, Observe{AgentId{BodyId{3}}, BodyId{0}}),
                      goes("", near(1.0, 0.1, 0.2), "close"), goes("close", AfterTime{2.0}, "start")}),
              IsEmpty());
}

TEST(Script, WhatIsRemovedTwiceOrAddedTwiceIsToldWithItsTime) {
  EXPECT_THAT(faults({at(5.0, RemoveBody{BodyId{3}}), at(9.0, RemoveBody{BodyId{3}})}),
              ElementsAre(HasSubstr("1: at = 9: \"uav3\" is not there")));
  EXPECT_THAT(faults({at(5.0, AddBody{BodyId{3}})}),
              ElementsAre(HasSubstr("0: at = 5: \"uav3\" is there already")));
  EXPECT_THAT(faults({at(9.0, AddBody{BodyId{3}}), at(5.0, RemoveBody{BodyId{3}})}), IsEmpty())
      << "by their times";
}

TEST(Script, WhatAnEventNobodyForeseesMayMendIsLeftToTheFlight) {
  const TeamEvent back{.name = "", .trigger = Signal{"back"}, .actions = {AddBody{BodyId{3}}}};
  EXPECT_THAT(faults({at(5.0, RemoveBody{BodyId{3}}), back, at(9.0, RemoveBody{BodyId{3}})}), IsEmpty());
}

TEST(Script, TwoEventsOfOneTimeMustNotContradictEachOther) {
  EXPECT_THAT(faults({at(5.0, RemoveBody{BodyId{3}}), at(5.0, AddBody{BodyId{3}})}),
              ElementsAre(HasSubstr("1: at = 5: \"uav3\" is changed twice at one time")));
  EXPECT_THAT(faults({at(5.0, Observe{AgentId{BodyId{3}}, BodyId{0}}),
                      at(5.0, Observe{AgentId{BodyId{3}}, BodyId{1}})}),
              ElementsAre(HasSubstr("the target of \"uav3\" is changed twice")));
  EXPECT_THAT(faults({at(5.0, RetuneTerm{.name = "sees3", .weight = 1.0}), at(5.0, RemoveTerm{"sees3"})}),
              ElementsAre(HasSubstr("\"sees3\" is changed twice")));
  TeamEvent one = at(5.0, RemoveTerm{"sees3"}), two = at(5.0, RemoveTerm{"off3"});
  one.enter = "a", two.enter = "b";
  EXPECT_THAT(faults({one, two}), ElementsAre(HasSubstr("enter = \"b\", and at the same time \"a\"")));
}

TEST(Script, AConditionThatNeverSettlesIsAFault) {
  const auto repeating = [](Condition when) {
    TeamEvent event{
        .name = "", .trigger = std::move(when), .actions = {RetuneTerm{.name = "sees3", .weight = 1.0}}};
    event.repeat = true;
    return event;
  };
  EXPECT_THAT(faults({repeating(near(1.0))}), ElementsAre(HasSubstr("could come about each period")));
  EXPECT_THAT(faults({repeating(near(1.0, 0.1))}), IsEmpty());
  EXPECT_THAT(faults({repeating(near(1.0, 0.0, 0.5))}), IsEmpty());
  EXPECT_THAT(faults({repeating(near(0.0, 0.1))}), ElementsAre(HasSubstr("never is below")));
  EXPECT_THAT(faults({repeating(near(1.0, -0.1, 1.0))}), ElementsAre(HasSubstr("hysteresis = -0.1")));
  EXPECT_THAT(faults({repeating(near(1.0, 0.1, not_a_number))}), ElementsAre(HasSubstr("dwell = nan")));
  TeamEvent timed = at(1.0, RemoveTerm{"sees3"});
  timed.repeat = true;
  EXPECT_THAT(faults({timed}), ElementsAre(HasSubstr("repeat = true of an event with a time")));
}

TEST(Script, NumbersOutOfRangeAreFaults) {
  EXPECT_THAT(faults({at(-1.0, RemoveTerm{"sees3"})}), ElementsAre(HasSubstr("at = -1")));
  TeamEvent ramped = at(1.0, RemoveTerm{"sees3"});
  ramped.ramp = -0.5;
  EXPECT_THAT(faults({ramped}), ElementsAre(HasSubstr("ramp = -0.5")));
  EXPECT_THAT(faults({goes("", AfterTime{-2.0}, "a")}), ElementsAre(HasSubstr("after = -2")));
  EXPECT_THAT(faults({{.name = "", .trigger = AtTime{1.0}}}), ElementsAre(HasSubstr("changes nothing")));
}

TEST(Script, AStageIsOneThatIsEntered) {
  EXPECT_THAT(faults({goes("closing", AfterTime{1.0}, "start")}),
              ElementsAre(HasSubstr("stage = \"closing\"")));
  EXPECT_THAT(faults({goes("start", AfterTime{1.0}, "start")}),
              ElementsAre(HasSubstr("another stage than its own")));
}

TEST(Script, StagesMustNotFollowEachOtherInNoTime) {
  EXPECT_THAT(
      faults({goes("start", near(1.0), "a"), goes("a", AfterTime{0.0}, "b"), goes("b", near(2.0), "a")}),
      ElementsAre(HasSubstr("a -> b -> a follow each other in no time")));
  EXPECT_THAT(
      faults({goes("start", near(1.0), "a"), goes("a", AfterTime{0.1}, "b"), goes("b", near(2.0), "a")}),
      IsEmpty());
  EXPECT_THAT(faults({goes("start", near(1.0), "a"), goes("a", near(1.0, 0.0, 0.2), "start")}), IsEmpty());
}

}  // namespace
}  // namespace sightline
