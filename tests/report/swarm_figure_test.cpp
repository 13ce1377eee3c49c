#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sightline/report/run_figures.hpp"

namespace sightline {
namespace {

/// Three robots on a line, the second on its way from the first to the third; and a post.
Recording three_robots() {
  Recording r;
  r.bodies.resize(4);
  r.controllers.resize(1);
  for (int k = 0; k < 10; ++k) {
    r.time.push_back(0.1 * k);
    r.controllers[0].pairs.push_back(k);
    const std::array<double, 4> x = {0.0, 1.0 + 0.5 * k, 10.0, 0.1};
    for (std::size_t i = 0; i < 4; ++i) r.bodies[i].p.push_back({x[i], 0.0, 0.0});
  }
  for (std::size_t i = 0; i < 3; ++i) r.bodies[i].is_agent = true;
  r.bodies[1].reference_p = {{0.0, 0.0, 0.0}, {9.0, 0.0, 0.0}};
  return r;
}

TEST(SwarmFigure, IsThereWhereRobotsAreKeptApart) {
  Recording r = three_robots();
  EXPECT_TRUE(swarm_drawing(r));
  r.controllers[0].pairs.clear();
  EXPECT_FALSE(swarm_drawing(r));
  EXPECT_FALSE(swarm_drawing(Recording{}));
}

TEST(SwarmFigure, TheNearestTwoAreRobotsAndTheWayToGoEndsAtTheReference) {
  const auto drawing = swarm_drawing(three_robots());
  ASSERT_TRUE(drawing);
  ASSERT_EQ(drawing->panels.size(), 3U);
  const auto y = [&](std::size_t panel, std::size_t curve) {
    return drawing->panels[panel].curves.at(curve).y;
  };
  for (std::size_t k = 0; k < 10; ++k) {
    const double x = 1.0 + 0.5 * static_cast<double>(k);
    EXPECT_DOUBLE_EQ(y(0, 0)[k], std::min(x, 10.0 - x));
    EXPECT_EQ(y(1, 0)[k], static_cast<double>(k));
    EXPECT_DOUBLE_EQ(y(2, 0)[k], 9.0 - x);
    EXPECT_DOUBLE_EQ(y(2, 1)[k], 9.0 - x);
  }
}

TEST(SwarmFigure, WhatIsNotKnownIsAGap) {
  Recording r = three_robots();
  for (Recording::Body& body : r.bodies) body.p[4] = {std::nan(""), 0.0, 0.0};
  const auto drawing = swarm_drawing(r);
  ASSERT_TRUE(drawing);
  EXPECT_TRUE(std::isnan(drawing->panels[0].curves[0].y[4]));
  EXPECT_TRUE(std::isnan(drawing->panels[2].curves[1].y[4]));
  EXPECT_TRUE(std::isfinite(drawing->panels[0].curves[0].y[5]));
}

}  // namespace
}  // namespace sightline
