#include "sightline/ocp/watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Two robots on a line; time goes on by 0.1 s at each look.
struct Line {
  explicit Line(std::vector<TeamEvent> events) : watch({std::move(events)}, team) {}

  Team team = event_team(2);
  Watch watch;
  std::vector<double> x = event_start(team), u = std::vector<double>(8);
  std::vector<Presence> presence = {Presence::steered, Presence::steered};
  std::vector<double> ages = {0, 0};
  double t = 0.0;

  std::vector<std::size_t> look() {
    const auto happening = watch.look({t, x, u, ages, presence});
    t += 0.1;
    return {happening.begin(), happening.end()};
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

TEST(Watch, AnEventOfATimeHappensOnceAtTheFirstPeriodThatIsNotEarlier) {
  Line line({when(AtTime{0.25}), when(AtTime{0.3})});
  for (int k = 0; k < 3; ++k) EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(0U, 1U)) << "0.3 s";
  for (int k = 0; k < 10; ++k) EXPECT_THAT(line.look(), IsEmpty());
}

TEST(Watch, AConditionHasToHoldForItsDwell) {
  Line line({when(nearer(1.0, 0.0, 0.25))});
  EXPECT_THAT(line.look(2.0), IsEmpty());
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.1), IsEmpty()) << "over: it begins anew";
  for (int k = 0; k < 3; ++k) EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(0.9), ElementsAre(0U));
  EXPECT_THAT(line.look(0.9), IsEmpty());
}

TEST(Watch, ItGoesOnToHoldWithinItsHysteresis) {
  Line line({when(nearer(1.0, 0.5, 0.25))});
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.4), IsEmpty());
  EXPECT_THAT(line.look(1.4), IsEmpty());
  EXPECT_THAT(line.look(1.4), ElementsAre(0U));
}

TEST(Watch, OneThatRepeatsHasToEndBefore) {
  TeamEvent event = when(nearer(1.0, 0.5));
  event.repeat = true;
  Line line({event});
  EXPECT_THAT(line.look(0.9), ElementsAre(0U));
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.4), IsEmpty());
  EXPECT_THAT(line.look(0.9), IsEmpty());
  EXPECT_THAT(line.look(1.6), IsEmpty());
  EXPECT_THAT(line.look(0.9), ElementsAre(0U));
}

TEST(Watch, WhatIsAbsentIsAtNoDistance) {
  Line line({when(nearer(1.0))});
  line.presence[1] = Presence::absent;
  EXPECT_THAT(line.look(0.5), IsEmpty());
  line.presence[1] = Presence::hold;
  EXPECT_THAT(line.look(0.5), ElementsAre(0U));
}

TEST(Watch, AnAngleALimitAndAnAgeAreMeasured) {
  const SensorMount mount{.pitch = 0.0, .offset = 0.0};
  Line line(
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

TEST(Watch, ASignalIsWaitedForFromAnyThread) {
  Line line({when(Signal{"go"})});
  EXPECT_FALSE(line.watch.signal("stop"));
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_TRUE(line.watch.signal("go"));
  EXPECT_THAT(line.look(), ElementsAre(0U));
  EXPECT_TRUE(line.watch.signal("go"));
  EXPECT_THAT(line.look(), IsEmpty());
}

TEST(Watch, StagesArmTheirEventsAnew) {
  TeamEvent go{.name = "", .trigger = nearer(1.0), .stage = "start", .enter = "close"};
  TeamEvent back{.name = "", .trigger = AfterTime{0.15}, .stage = "close", .enter = "start"};
  Line line({go, back});
  EXPECT_EQ(line.watch.stage(), "start");
  for (int round = 0; round < 3; ++round) {
    EXPECT_THAT(line.look(0.5), ElementsAre(0U));
    EXPECT_EQ(line.watch.stage(), "close");
    EXPECT_THAT(line.look(0.5), IsEmpty());
    EXPECT_THAT(line.look(0.5), ElementsAre(1U));
    EXPECT_EQ(line.watch.stage(), "start");
  }
}

TEST(Watch, ASignalOfAnotherStageIsLost) {
  TeamEvent go{.name = "", .trigger = AtTime{0.2}, .enter = "later"};
  TeamEvent told = when(Signal{"now"});
  told.stage = "later";
  Line line({go, told});
  EXPECT_TRUE(line.watch.signal("now"));
  for (int k = 0; k < 2; ++k) EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(0U));
  EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_TRUE(line.watch.signal("now"));
  EXPECT_THAT(line.look(), ElementsAre(1U));
}

TEST(Watch, StagesOfUnlikeRegionsGoTheirOwnWays) {
  const TeamEvent a{.name = "", .trigger = AtTime{0.1}, .stage = "door:open", .enter = "door:shut"};
  const TeamEvent b{.name = "", .trigger = AtTime{0.2}, .stage = "start", .enter = "later"};
  const TeamEvent c{.name = "", .trigger = AfterTime{0.2}, .stage = "door:shut", .enter = "door:open"};
  const Team team = event_team(2);
  Watch watch({{a, b, c}, {"start", "door:open"}}, team);
  const std::vector<double> x = event_start(team), u(8);
  const auto look = [&](double t) {
    const auto happening = watch.look({t, x, u, {}, {}});
    return std::vector<std::size_t>(happening.begin(), happening.end());
  };
  EXPECT_THAT(look(0.0), IsEmpty());
  EXPECT_THAT(look(0.1), ElementsAre(0U));
  EXPECT_EQ(watch.stage("door"), "door:shut");
  EXPECT_EQ(watch.stage(), "start");
  EXPECT_THAT(look(0.2), ElementsAre(1U));
  EXPECT_THAT(look(0.3), ElementsAre(2U)) << "0.2 s after its own stage began";
  EXPECT_EQ(watch.stage("door"), "door:open");
  EXPECT_EQ(watch.stage(), "later");
  EXPECT_EQ(watch.stage("window"), "");
}

TEST(Watch, ANearerRobotIsNearerThanOneThatIsNotSteered) {
  const Condition nearer{NearerThan{BodyId{1}, BodyId{2}, BodyId{0}}, Condition::Side::above, 0.3};
  const Team team = event_team(3);
  std::vector<double> x = event_start(team), u(12);
  std::vector<Presence> presence(3, Presence::steered);
  const auto happens = [&] {
    Watch watch({{when(nearer)}}, team);
    return !watch.look({0.0, x, u, {}, presence}).empty();
  };
  EXPECT_FALSE(happens());  // robot 2 stands behind robot 1
  for (const Presence gone : {Presence::absent, Presence::hold, Presence::land}) {
    presence[1] = gone;
    presence[2] = Presence::steered;
    EXPECT_TRUE(happens());
    presence[2] = gone;
    EXPECT_FALSE(happens());
  }
}

}  // namespace
}  // namespace sightline
