#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(MoveBody, TheLastMoveOfABodyCounts) {
  Team team = event_team(1);
  const BodyId post = team.add(Obstacle{"post"});
  ActiveTeam active_team(team);
  EXPECT_EQ(active_team.apply(MoveBody{post, {1, 2, 3}}, 2.0, 0.5), "");
  EXPECT_EQ(active_team.apply(MoveBody{post, {4, 5, 6}}, 3.0, 1.0), "");
  const auto moves = active_team.membership().around.moves;
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_EQ(moves[0].to.x, 4.0);
  EXPECT_EQ(moves[0].begin, 3.0);
  EXPECT_EQ(moves[0].duration, 1.0);
}

TEST(MoveBody, OfARobotOrOfWhatIsNotThereIsRefused) {
  Team team = event_team(1);
  const BodyId post = team.add(Obstacle{"post"});
  ActiveTeam active_team(team, {Presence::steered, Presence::absent});
  EXPECT_THAT(active_team.apply(MoveBody{BodyId{0}, {}}, 0.0, 1.0), HasSubstr("\"uav0\" is a robot"));
  EXPECT_THAT(active_team.apply(MoveBody{post, {}}, 0.0, 1.0), HasSubstr("\"post\" is not there"));
}

}  // namespace
}  // namespace sightline
