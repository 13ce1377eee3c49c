#include "sightline/report/graph_figure.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

Recording robots(std::size_t n) {
  Recording r;
  for (std::size_t i = 0; i < n; ++i) {
    Recording::Body& body = r.bodies.emplace_back();
    body.name = fmt::format("r{}", i);
    body.is_agent = true;
  }
  return r;
}

/// Each robot observes the one before; felt by the observer, or by both.
Recording chain_of(std::size_t n, bool by_both) {
  Recording r = robots(n);
  for (std::size_t i = 1; i < n; ++i) {
    r.pairs.push_back({.observer = i, .target = i - 1});
    r.couplings.push_back({i, i - 1, true, by_both});
  }
  return r;
}

int count(const std::string& text, const std::string& what) {
  int n = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(GraphFigures, HaveANodeForEachBodyAndAnArrowForEachObservation) {
  for (const std::size_t n : {2U, 3U, 8U, 17U, 64U}) {
    const auto figures = graph_figures(chain_of(n, false));
    ASSERT_EQ(figures.size(), 2U);
    for (const Figure& figure : figures) {
      EXPECT_EQ(count(figure.svg, "<circle"), static_cast<int>(n));
      EXPECT_EQ(count(figure.svg, "marker-end"), static_cast<int>(n) - 1);
      EXPECT_EQ(count(figure.svg, "marker-start"), 0);
      EXPECT_EQ(count(figure.svg, "<text"), count(figure.svg, "</text>"));
    }
  }
}

TEST(GraphFigures, ALineThatBothFeelIsOneWithTwoHeads) {
  const auto figures = graph_figures(chain_of(5, true));
  EXPECT_EQ(count(figures.at(0).svg, "marker-start"), 0) << "they do not observe each other";
  EXPECT_EQ(count(figures.at(1).svg, "marker-start"), 4);
  EXPECT_EQ(count(figures.at(1).svg, "marker-end"), 4);
}

TEST(GraphFigures, SayTheKindOfInfluenceThatTheSolverSees) {
  EXPECT_EQ(influence_words(robots(3)), "no robot feels another");
  EXPECT_EQ(influence_words(chain_of(8, false)), "a cascade of depth 7");
  EXPECT_THAT(influence_words(chain_of(8, true)), HasSubstr("mutual"));
  Recording ring = chain_of(4, false);
  ring.couplings.push_back({0, 3, true, false});
  EXPECT_THAT(influence_words(ring), HasSubstr("cyclic"));
  EXPECT_THAT(graph_figures(chain_of(8, false)).at(1).caption, HasSubstr("a cascade of depth 7"));
}

TEST(GraphFigures, AnyTwoRobotsOfASwarmInfluenceEachOther) {
  Recording r = robots(5);
  r.swarms = {{0, 2, 3, 4}};
  EXPECT_EQ(count(graph_figures(r).at(0).svg, "<path d=\"M"), 6 + 2) << "lines, and the heads' own";
  EXPECT_THAT(influence_words(r), HasSubstr("mutual"));
  r.couplings.push_back({1, 0, true, false});
  EXPECT_THAT(influence_words(r), HasSubstr("cyclic"));
}

TEST(GraphFigures, AnObstacleIsThereIfARobotFeelsItAndRobotsAlwaysAre) {
  Recording r = robots(3);
  for (const char* name : {"rock", "tree"}) r.bodies.emplace_back().name = name;
  r.couplings.push_back({0, 3, true, false});
  const auto figures = graph_figures(r);
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_EQ(count(figures[0].svg, "<circle"), 4);
  EXPECT_THAT(figures[0].svg, HasSubstr(">rock<"));
  EXPECT_THAT(figures[0].svg, Not(HasSubstr(">tree<")));
  EXPECT_THAT(figures[0].caption, HasSubstr("no robot feels another"));
}

TEST(GraphFigures, AreLeftOutWhereNothingIsCoupledOrTooManyAre) {
  EXPECT_TRUE(graph_figures(robots(2)).empty());
  EXPECT_TRUE(graph_figures(chain_of(graph_bodies_max + 1, false)).empty());
}

TEST(GraphFigures, ShowNamesAsTextAndAreTheSameAgain) {
  Recording r = chain_of(2, false);
  r.bodies[0].name = "<a>&b";
  const auto figures = graph_figures(r);
  EXPECT_THAT(figures.at(0).svg, HasSubstr("&lt;a&gt;&amp;b"));
  EXPECT_EQ(figures.at(0).svg, graph_figures(r).at(0).svg);
}

}  // namespace
}  // namespace sightline
