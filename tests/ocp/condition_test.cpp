#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "sightline/potentials.hpp"
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

}  // namespace
}  // namespace sightline
