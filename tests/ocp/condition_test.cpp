#include "sightline/ocp/event/condition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/potential/sensor_cone.hpp"
#include "tests/support/monitored_line.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

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

TEST(Condition, IsSaid) {
  const Team team = event_team(2);
  const BodyId uav0{0}, uav1{1};
  using enum Condition::Side;
  EXPECT_EQ(nearer(1.5, 0.2, 0.5).describe(team),
            "when the distance of uav0 and uav1 is below 1.5, hysteresis 0.2, for 0.5 s");
  EXPECT_EQ((Condition{.measure = ViewAngleOf{uav0, uav1, {}}, .threshold = 0.5}.describe(team)),
            "when the view angle of uav0 to uav1 is above 0.5");
  const ExcessOf view{SensorCone{}, uav0, uav1};
  EXPECT_EQ(Condition{.measure = view}.describe(team), "when sensor_cone is broken between uav0 and uav1");
  EXPECT_EQ((Condition{.measure = view, .side = below}.describe(team)),
            "when sensor_cone holds between uav0 and uav1");
  EXPECT_EQ((Condition{.measure = view, .threshold = 0.1}.describe(team)),
            "when the excess of sensor_cone between uav0 and uav1 is above 0.1");
}

}  // namespace
}  // namespace sightline
