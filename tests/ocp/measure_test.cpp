#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/monitored_line.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

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

}  // namespace
}  // namespace sightline
