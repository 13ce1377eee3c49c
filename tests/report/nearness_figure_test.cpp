#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/report/run_figures.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

// Bodies that walk at random, the last of which nobody controls.
Recording walking_bodies(Random& random, std::size_t bodies, std::size_t periods = 40) {
  Recording r;
  r.period = 0.1;
  r.bodies.resize(bodies);
  for (std::size_t k = 0; k < periods; ++k) r.time.push_back(0.1 * static_cast<double>(k));
  for (std::size_t i = 0; i < bodies; ++i) {
    r.bodies[i].name = "body" + std::to_string(i);
    r.bodies[i].is_agent = i + 1 < bodies;
    for (std::size_t k = 0; k < periods; ++k) r.bodies[i].p.push_back(random_point(random, 5.0));
  }
  return r;
}

TEST(NearestPairs, AreThoseThatCameNearestTheNearestFirst) {
  Random random(1);
  for (int n = 0; n < 20; ++n) {
    const Recording r = walking_bodies(random, 6);
    const auto pairs = nearest_pairs(r, 100);
    ASSERT_EQ(pairs.size(), 15U);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      double least = 1e9;
      for (std::size_t k = 0; k < r.time.size(); ++k)
        least = std::min(least, norm(r.bodies[pairs[i].first].p[k] - r.bodies[pairs[i].second].p[k]));
      EXPECT_NEAR(pairs[i].least, least, 1e-12);
      if (i > 0) {
        EXPECT_LE(pairs[i - 1].least, pairs[i].least);
      }
    }
    EXPECT_EQ(nearest_pairs(r, 3).size(), 3U);
  }
}

TEST(NearestPairs, HaveARobotEachAndWereThereAtOnce) {
  Random random(2);
  Recording r = walking_bodies(random, 4);
  r.bodies[2].is_agent = false;
  for (auto& p : r.bodies[0].p) p.x = std::nan("");
  const auto pairs = nearest_pairs(r, 10);
  ASSERT_EQ(pairs.size(), 2U);
  for (const Nearness& pair : pairs) EXPECT_EQ(pair.first, 1U);
}

TEST(NearnessFigure, ShowsTheHardDistanceBelowTheCurvesOfAtMostSixPairs) {
  Random random(3);
  Recording r = walking_bodies(random, 9);
  r.d_hard = {0.6, 1.2};
  const auto drawing = nearness_drawing(r, Curves(r));
  ASSERT_TRUE(drawing);
  EXPECT_EQ(drawing->panels[0].curves.size(), 8U);
  EXPECT_EQ(drawing->panels[0].curves.back().title, "d_hard = 1.2 m");
  EXPECT_THAT(drawing->caption, HasSubstr("six pairs"));
  r.d_hard.clear();
  EXPECT_THAT(nearness_drawing(r, Curves(r))->caption, Not(HasSubstr("dashed")));
}

TEST(NearnessFigure, IsLeftOutWhereThePairsOwnFigureTellsIt) {
  Random random(4);
  Recording r = walking_bodies(random, 2);
  r.pairs.push_back({.observer = 0, .target = 1});
  EXPECT_FALSE(nearness_drawing(r, Curves(r)));
  r.d_hard = {0.6};
  EXPECT_TRUE(nearness_drawing(r, Curves(r)));
  r.bodies.pop_back();
  EXPECT_FALSE(nearness_drawing(r, Curves(r)));
}

}  // namespace
}  // namespace sightline
