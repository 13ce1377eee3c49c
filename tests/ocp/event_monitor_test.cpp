#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "sightline/events.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Two robots on a line; time goes on by 0.1 s at each look.
struct MonitoredLine {
  explicit MonitoredLine(std::vector<TeamEvent> events) : monitor({std::move(events)}, team) {}

  Team team = event_team(2);
  EventMonitor monitor;
  std::vector<double> x = event_start(team), u = std::vector<double>(8);
  std::vector<Presence> presence = {Presence::steered, Presence::steered};
  std::vector<double> ages = {0, 0};
  double t = 0.0;

  std::vector<std::size_t> look() {
    const auto triggered = monitor.look({t, x, u, ages, presence});
    t += 0.1;
    return {triggered.begin(), triggered.end()};
  }
  std::vector<std::size_t> look(double distance) {
    x[7] = x[0] - distance, x[8] = x[1], x[9] = x[2];
    return look();
  }
};

TeamEvent when(Trigger trigger) {
  return {.name = "", .trigger = std::move(trigger), .actions = {RemoveTerm{"sees1"}}};
}
Condition nearer(double below, double hysteresis = 0.0, double dwell = 0.0) {
  return {DistanceOf{BodyId{0}, BodyId{1}}, Condition::Side::below, below, hysteresis, dwell};
}

TEST(AtTime, AnEventOfATimeHappensOnceAtTheFirstPeriodThatIsNotEarlier) {
  MonitoredLine line({when(AtTime{0.25}), when(AtTime{0.3})});
  for (int k = 0; k < 3; ++k) EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(0U, 1U)) << "0.3 s";
  for (int k = 0; k < 10; ++k) EXPECT_THAT(line.look(), IsEmpty());
}

TEST(AfterTime, CountsFromWhereItsStageBegan) {
  TeamEvent later = when(AfterTime{0.2});
  later.stage = "later";
  MonitoredLine line({{.name = "", .trigger = AtTime{0.3}, .enter = "later"}, later, when(AfterTime{0.1})});
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(2U)) << "of all stages: from the beginning of the run";
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(0U));
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(1U)) << "0.5 s";
}

TEST(Condition, AConditionHasToHoldForItsDwell) {
  MonitoredLine line({when(nearer(1.0, 0.0, 0.25))});
  EXPECT_THAT(line.look(2.0), IsEmpty());
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.1), IsEmpty()) << "over: it begins anew";
  for (int k = 0; k < 3; ++k) EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(0.9), ElementsAre(0U));
  EXPECT_THAT(line.look(0.9), IsEmpty());
}

TEST(Condition, ItGoesOnToHoldWithinItsHysteresis) {
  MonitoredLine line({when(nearer(1.0, 0.5, 0.25))});
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.4), IsEmpty());
  EXPECT_THAT(line.look(1.4), IsEmpty());
  EXPECT_THAT(line.look(1.4), ElementsAre(0U));
}

TEST(Condition, OneThatRepeatsHasToEndBefore) {
  TeamEvent event = when(nearer(1.0, 0.5));
  event.repeat = true;
  MonitoredLine line({event});
  EXPECT_THAT(line.look(0.9), ElementsAre(0U));
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.4), IsEmpty());
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.6), IsEmpty());
  EXPECT_THAT(line.look(0.9), ElementsAre(0U));
}

TEST(Signal, ASignalIsWaitedForFromAnyThread) {
  MonitoredLine line({when(Signal{"go"})});
  EXPECT_FALSE(line.monitor.signal("stop"));
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_TRUE(line.monitor.signal("go"));
  EXPECT_THAT(line.look(), ElementsAre(0U));
  EXPECT_TRUE(line.monitor.signal("go"));
  EXPECT_THAT(line.look(), IsEmpty());
}

TEST(Signal, ASignalOfAnotherStageIsLost) {
  TeamEvent go{.name = "", .trigger = AtTime{0.2}, .enter = "later"};
  TeamEvent reported = when(Signal{"now"});
  reported.stage = "later";
  MonitoredLine line({go, reported});
  EXPECT_TRUE(line.monitor.signal("now"));
  for (int k = 0; k < 2; ++k) EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(0U));
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_TRUE(line.monitor.signal("now"));
  EXPECT_THAT(line.look(), ElementsAre(1U));
}

TEST(Measure, WhatIsAbsentIsAtNoDistance) {
  MonitoredLine line({when(nearer(1.0))});
  line.presence[1] = Presence::absent;
  EXPECT_THAT(line.look(0.5), IsEmpty());
  line.presence[1] = Presence::hold;
  EXPECT_THAT(line.look(0.5), ElementsAre(0U));
}

TEST(Measure, AnAngleALimitAndAnAgeAreMeasured) {
  const SensorMount mount{.pitch = 0.0, .offset = 0.0};
  MonitoredLine line(
      {when(Condition{ViewAngleOf{BodyId{1}, BodyId{0}, mount}, Condition::Side::above, 1.0}),
       when(Condition{ExcessOf{KeepOut{.d_min = 1.0}, BodyId{0}, BodyId{1}}, Condition::Side::above, 0.2}),
       when(Condition{AgeOf{BodyId{1}}, Condition::Side::above, 0.5})});
  EXPECT_THAT(line.look(1.0), IsEmpty());
  line.x[10] = 0.0, line.x[11] = 1.0;  // turns away
  EXPECT_THAT(line.look(1.0), ElementsAre(0U));
  EXPECT_THAT(line.look(0.7), ElementsAre(1U));
  line.ages[1] = 0.6;
  EXPECT_THAT(line.look(1.0), ElementsAre(2U));
}

TEST(Measure, ANearerRobotIsNearerThanOneThatIsNotSteered) {
  const Condition nearer{NearerThan{BodyId{1}, BodyId{2}, BodyId{0}}, Condition::Side::above, 0.3};
  const Team team = event_team(3);
  std::vector<double> x = event_start(team), u(12);
  std::vector<Presence> presence(3, Presence::steered);
  const auto occurs = [&] {
    EventMonitor monitor({{when(nearer)}}, team);
    return !monitor.look({0.0, x, u, {}, presence}).empty();
  };
  EXPECT_FALSE(occurs());  // robot 2 stands behind robot 1
  for (const Presence gone : {Presence::absent, Presence::hold, Presence::land}) {
    presence[1] = gone;
    presence[2] = Presence::steered;
    EXPECT_TRUE(occurs());
    presence[2] = gone;
    EXPECT_FALSE(occurs());
  }
}

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

TEST(EventMonitor, StagesArmTheirEventsAnew) {
  TeamEvent go{.name = "", .trigger = nearer(1.0), .stage = "start", .enter = "close"};
  TeamEvent back{.name = "", .trigger = AfterTime{0.15}, .stage = "close", .enter = "start"};
  MonitoredLine line({go, back});
  EXPECT_EQ(line.monitor.stage(), "start");
  for (int round = 0; round < 3; ++round) {
    EXPECT_THAT(line.look(0.5), ElementsAre(0U));
    EXPECT_EQ(line.monitor.stage(), "close");
    EXPECT_THAT(line.look(0.5), IsEmpty());
    EXPECT_THAT(line.look(0.5), ElementsAre(1U));
    EXPECT_EQ(line.monitor.stage(), "start");
  }
}

TEST(EventMonitor, StagesOfUnlikeRegionsGoTheirOwnWays) {
  const TeamEvent a{.name = "", .trigger = AtTime{0.1}, .stage = "door:open", .enter = "door:shut"};
  const TeamEvent b{.name = "", .trigger = AtTime{0.2}, .stage = "start", .enter = "later"};
  const TeamEvent c{.name = "", .trigger = AfterTime{0.2}, .stage = "door:shut", .enter = "door:open"};
  const Team team = event_team(2);
  EventMonitor monitor({{a, b, c}, {"start", "door:open"}}, team);
  const std::vector<double> x = event_start(team), u(8);
  const auto look = [&](double t) {
    const auto triggered = monitor.look({t, x, u, {}, {}});
    return std::vector<std::size_t>(triggered.begin(), triggered.end());
  };
  EXPECT_THAT(look(0.0), IsEmpty());
  EXPECT_THAT(look(0.1), ElementsAre(0U));
  EXPECT_EQ(monitor.stage("door"), "door:shut");
  EXPECT_EQ(monitor.stage(), "start");
  EXPECT_THAT(look(0.2), ElementsAre(1U));
  EXPECT_THAT(look(0.3), ElementsAre(2U)) << "0.2 s after its own stage began";
  EXPECT_EQ(monitor.stage("door"), "door:open");
  EXPECT_EQ(monitor.stage(), "later");
  EXPECT_EQ(monitor.stage("window"), "");
}

}  // namespace
}  // namespace sightline
