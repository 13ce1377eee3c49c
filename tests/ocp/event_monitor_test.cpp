#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/monitored_line.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

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
