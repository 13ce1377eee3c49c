#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/monitored_line.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

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

}  // namespace
}  // namespace sightline
