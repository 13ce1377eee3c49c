#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

const InjectFault lost{.kind = Surroundings::FaultKind::dropout, .body = BodyId{0}, .lasts = 0.5};

TEST(InjectFault, FaultsThatAreOverMakeRoom) {
  ActiveTeam active_team(event_team(1));
  EXPECT_EQ(active_team.apply(lost, 1.0, 0.0), "");
  EXPECT_EQ(active_team.apply(lost, 1.2, 0.0), "");
  ASSERT_EQ(active_team.membership().around.faults.size(), 2U);
  EXPECT_EQ(active_team.membership().around.faults[0].until, 1.5);
  EXPECT_EQ(active_team.apply(lost, 1.6, 0.0), "");
  EXPECT_EQ(active_team.membership().around.faults.size(), 2U);
}

TEST(InjectFault, MoreThanThereIsRoomForAreRefused) {
  ActiveTeam active_team(event_team(1));
  for (std::size_t i = 0; i < Surroundings::faults_max; ++i) EXPECT_EQ(active_team.apply(lost, 1.0, 0.0), "");
  EXPECT_THAT(active_team.apply(lost, 1.0, 0.0), testing::HasSubstr("32 faults are in force already"));
}

}  // namespace
}  // namespace sightline
