#include <gtest/gtest.h>

#include "sightline/estimator.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

std::vector<Localized> chain(int robots) {
  std::vector<Localized> all;
  for (int i = 0; i < robots; ++i)
    all.push_back({"uav" + std::to_string(i), i == 0, i == 0 ? std::vector<int>{} : std::vector<int>{i - 1}});
  return all;
}

TEST(LocalizationGraph, AChainHasATierForEachHop) {
  const LocalizationGraph graph(chain(5));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(graph.tier(i), i);
  EXPECT_TRUE(graph.uses(3, 2));
  EXPECT_FALSE(graph.uses(2, 3));
  EXPECT_EQ(graph.error_of(1, 0), OtherError::fresh);
  EXPECT_EQ(graph.error_of(3, 2), OtherError::lasting);
}

TEST(LocalizationGraph, ARobotIsAboveAllThatItIsLocalizedBy) {
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    // Any robot observes some of those before it.
    std::vector<Localized> robots = chain(12);
    for (int i = 1; i < 12; ++i) {
      robots[static_cast<std::size_t>(i)].is_anchor = uniform(random, 0, 1) < 0.2;
      for (int j = 0; j < i; ++j)
        if (uniform(random, 0, 1) < 0.3) robots[static_cast<std::size_t>(i)].observes.push_back(j);
    }
    const LocalizationGraph graph(robots);
    int before = 0;
    for (const int i : graph.order()) {
      EXPECT_GE(graph.tier(i), before);
      before = graph.tier(i);
      EXPECT_EQ(graph.tier(i) == 0, graph.robot(i).is_anchor);
      for (int j = 0; j < graph.robots(); ++j)
        EXPECT_TRUE(!graph.uses(i, j) || graph.tier(j) < graph.tier(i));
    }
  }
}

TEST(LocalizationGraph, ACircleIsRefusedByItsRobotsNames) {
  std::vector<Localized> robots = chain(4);
  robots[1].observes = {0, 3};
  EXPECT_EQ(
      refusal_of([&] { return LocalizationGraph(robots); }),
      "robots are localized in a circle, \"uav1\" by \"uav3\", \"uav3\" by \"uav2\", \"uav2\" by \"uav1\", "
      "expected none: information would be counted twice");
}

TEST(LocalizationGraph, WithinACircleThatIsAllowedNothingIsSupposedOfTheErrors) {
  std::vector<Localized> robots = chain(5);
  robots[1].observes = {0, 2};
  const LocalizationGraph graph(robots, Cycles::intersected);
  EXPECT_EQ(graph.error_of(1, 2), OtherError::unknown);
  EXPECT_EQ(graph.error_of(2, 1), OtherError::unknown);
  EXPECT_EQ(graph.error_of(1, 0), OtherError::fresh);
  EXPECT_EQ(graph.error_of(3, 2), OtherError::lasting);
  EXPECT_EQ(graph.tier(1), graph.tier(2));
  EXPECT_EQ(graph.tier(3), graph.tier(2) + 1);
}

TEST(LocalizationGraph, ARobotWithoutAPathToAnAnchorIsRefused) {
  std::vector<Localized> robots = chain(3);
  robots[0].is_anchor = false;
  EXPECT_EQ(refusal_of([&] { return LocalizationGraph(robots); }),
            "\"uav0\" observes no localized robot, expected a path from it to a robot whose pose "
            "is known");
  robots = chain(3);
  robots[1].observes = {2};
  robots[2].observes = {1};
  EXPECT_EQ(refusal_of([&] { return LocalizationGraph(robots, Cycles::intersected); }),
            "\"uav1\" observes no localized robot, expected a path from it to a robot whose pose "
            "is known");
}

TEST(LocalizationGraph, WhomNobodyKnowsIsRefused) {
  std::vector<Localized> robots = chain(3);
  robots[2].observes = {7};
  EXPECT_EQ(refusal_of([&] { return LocalizationGraph(robots); }),
            "\"uav2\" observes robot 7, expected 0 to 2");
  robots[2].observes = {2};
  EXPECT_EQ(refusal_of([&] { return LocalizationGraph(robots); }),
            "\"uav2\" observes itself, expected another robot");
}

}  // namespace
}  // namespace sightline
