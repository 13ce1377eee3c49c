#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/monitored_line.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(AtTime, AnEventOfATimeHappensOnceAtTheFirstPeriodThatIsNotEarlier) {
  MonitoredLine line({when(AtTime{0.25}), when(AtTime{0.3})});
  for (int k = 0; k < 3; ++k) EXPECT_THAT(line.look(), IsEmpty());
  EXPECT_THAT(line.look(), ElementsAre(0U, 1U)) << "0.3 s";
  for (int k = 0; k < 10; ++k) EXPECT_THAT(line.look(), IsEmpty());
}

}  // namespace
}  // namespace sightline
