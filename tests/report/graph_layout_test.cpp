#include "sightline/report/graph_layout.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Kind = GraphLayout::Kind;

NodeGraph chain_of(std::size_t n) {
  NodeGraph graph{n};
  for (std::size_t i = 1; i < n; ++i) graph.arrows.emplace_back(i, i - 1);
  return graph;
}

NodeGraph star_of(std::size_t n) {
  NodeGraph graph{n};
  for (std::size_t i = 1; i < n; ++i) graph.arrows.emplace_back(i, 0);
  return graph;
}

NodeGraph ring_of(std::size_t n) {
  NodeGraph graph = chain_of(n);
  graph.arrows.emplace_back(0, n - 1);
  return graph;
}

/// Arrows from later nodes of a random order to earlier ones: no circle.
NodeGraph random_cascade(Random& random, std::size_t n) {
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), random);
  NodeGraph graph{n};
  for (std::size_t i = 1; i < n; ++i) {
    for (std::size_t k = random() % 3; k > 0; --k) graph.arrows.emplace_back(order[i], order[random() % i]);
  }
  return graph;
}

/// All nodes lie in the picture, none upon another.
void expect_legible(const GraphLayout& layout, double apart) {
  for (std::size_t i = 0; i < layout.nodes.size(); ++i) {
    const auto& a = layout.nodes[i];
    EXPECT_GT(a.x, 20.0);
    EXPECT_LT(a.x, layout.width - 20.0);
    EXPECT_GT(a.y, 20.0);
    EXPECT_LT(a.y, layout.height - 20.0);
    EXPECT_NEAR(std::hypot(a.out_x, a.out_y), 1.0, 1e-9);
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT(std::hypot(a.x - layout.nodes[j].x, a.y - layout.nodes[j].y), apart);
    }
  }
}

TEST(GraphLayout, EachDepthIsOneMoreThanThatOfTheDeepestItLeansOn) {
  Random random(1);
  for (int n = 0; n < 200; ++n) {
    const NodeGraph graph = random_cascade(random, 1 + random() % 30);
    const auto depths = depths_of(graph);
    ASSERT_EQ(depths.size(), graph.nodes);
    std::vector<std::size_t> expected(graph.nodes, 0);
    for (const auto& [from, to] : graph.arrows) {
      EXPECT_GT(depths[from], depths[to]);
      expected[from] = std::max(expected[from], depths[to] + 1);
    }
    EXPECT_EQ(depths, expected);
  }
}

TEST(GraphLayout, ArrowsInACircleHaveNoDepth) {
  for (std::size_t n = 2; n < 20; ++n) EXPECT_TRUE(depths_of(ring_of(n)).empty());
}

TEST(GraphLayout, AnyGraphOfUpTo64NodesIsLegible) {
  Random random(2);
  for (std::size_t n = 1; n <= 64; ++n) {
    for (const NodeGraph& graph : {chain_of(n), star_of(n), random_cascade(random, n), NodeGraph{n}}) {
      expect_legible(layout_of(graph), 20.0);
    }
    if (n > 1) expect_legible(layout_of(ring_of(n)), 20.0);
  }
}

TEST(GraphLayout, InColumnsEveryArrowGoesToTheLeft) {
  Random random(3);
  int columns = 0;
  for (int n = 0; n < 200; ++n) {
    const NodeGraph graph = random_cascade(random, 2 + random() % 30);
    const GraphLayout layout = layout_of(graph);
    if (layout.kind != Kind::columns) continue;
    ++columns;
    for (const auto& [from, to] : graph.arrows) EXPECT_GT(layout.nodes[from].x, layout.nodes[to].x + 20.0);
  }
  EXPECT_GT(columns, 50);
  EXPECT_EQ(layout_of(chain_of(8)).kind, Kind::columns);
  EXPECT_EQ(layout_of(star_of(17)).kind, Kind::columns);
  EXPECT_EQ(layout_of(ring_of(8)).kind, Kind::circle);
}

}  // namespace
}  // namespace sightline
