#include "sightline/report/figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> walk(Random& random, std::size_t rows) {
  std::vector<double> y(rows);
  double value = 0.0;
  for (double& v : y) v = value += uniform(random, -1, 1);
  return y;
}

Drawing drawing(std::vector<double> x, std::vector<double> y, std::string title = "y") {
  return {
      .title = "Picture",
      .caption = "",
      .panels = {
          {.x_label = "x", .y_label = "y", .curves = {{std::move(title), 0, Drawing::Mark::line, x, y}}}}};
}

Drawing field(Drawing::Grid::View view, double height) {
  Drawing::Panel panel{.x_label = "x [m]", .y_label = "y [m]"};
  panel.height = 200;
  panel.title = "panel's title";
  panel.grid = {.view = view, .across = 4, .label = "z [m]"};
  for (int i = 0; i < 16; ++i) {
    panel.grid.x.push_back(i % 4), panel.grid.y.push_back(i / 4), panel.grid.z.push_back(height * i);
  }
  return {.title = "Field", .caption = "", .panels = {panel, panel}, .columns = 2};
}

TEST(RowsToDraw, RiseWithinTheRowsThereAreFromTheFirstToTheLastAndAreNotTooMany) {
  Random random(1);
  for (int n = 0; n < 500; ++n) {
    const std::size_t rows = 1 + random() % 3000, most = 6 + random() % 500;
    const auto x = walk(random, rows), y = walk(random, rows);
    const std::array columns = {std::span<const double>(x), std::span<const double>(y)};
    const auto kept = rows_to_draw(columns, most);
    ASSERT_LE(kept.size(), most);
    ASSERT_EQ(kept.front(), 0u);
    ASSERT_EQ(kept.back(), rows - 1);
    for (std::size_t i = 1; i < kept.size(); ++i) ASSERT_LT(kept[i - 1], kept[i]);
    if (rows <= most) {
      ASSERT_EQ(kept.size(), rows);
    }
  }
}

TEST(RowsToDraw, KeepTheGreatestAndTheLeastOfEachColumnBetweenGaps) {
  Random random(2);
  for (int n = 0; n < 500; ++n) {
    const std::size_t rows = 100 + random() % 3000;
    std::vector<std::vector<double>> columns = {walk(random, rows), walk(random, rows)};
    for (int gap = 0; gap < 20; ++gap) columns[random() % 2][random() % rows] = nan;
    const std::array spans = {std::span<const double>(columns[0]), std::span<const double>(columns[1])};
    const auto kept = rows_to_draw(spans, 6 + random() % 90);
    for (const auto& column : columns) {
      double low = INFINITY, high = -INFINITY, kept_low = INFINITY, kept_high = -INFINITY;
      for (const double v : column) low = std::fmin(low, v), high = std::fmax(high, v);
      for (const std::size_t i : kept) {
        kept_low = std::fmin(kept_low, column[i]), kept_high = std::fmax(kept_high, column[i]);
      }
      ASSERT_EQ(kept_low, low);
      ASSERT_EQ(kept_high, high);
    }
  }
}

TEST(RowsToDraw, KeepAStretchWithoutNumbersAsAGap) {
  std::vector<double> y(1000, 1.0);
  std::fill(y.begin() + 300, y.begin() + 600, nan);
  const std::array columns = {std::span<const double>(y)};
  const auto kept = rows_to_draw(columns, 30);
  EXPECT_TRUE(std::any_of(kept.begin(), kept.end(), [&](std::size_t i) { return std::isnan(y[i]); }));
}

TEST(RowsToDraw, AreNoneOfNothing) { EXPECT_TRUE(rows_to_draw({}, 10).empty()); }

TEST(Draw, GivesOneElementThatTakesThePagesColourAndAsksForNothingElse) {
  const auto figures = draw({drawing({0, 1, 2}, {1, 3, 2})});
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].title, "Picture");
  const std::string& svg = figures[0].svg;
  EXPECT_EQ(svg.find("<svg"), 0u);
  EXPECT_THAT(svg, HasSubstr("</svg>"));
  EXPECT_THAT(svg, HasSubstr("currentColor"));
  EXPECT_THAT(svg, Not(HasSubstr("<?xml")));
  EXPECT_THAT(svg, Not(HasSubstr("<!DOCTYPE")));
  EXPECT_THAT(svg, Not(HasSubstr("\"black\"")));
}

TEST(Draw, GivesThePicturesOfAPageIdsThatDiffer) {
  const auto figures = draw({drawing({0, 1}, {1, 2}), drawing({0, 1}, {1, 2})});
  ASSERT_EQ(figures.size(), 2u);
  std::set<std::string> ids;
  std::size_t count = 0;
  for (const Figure& figure : figures) {
    const std::string& svg = figure.svg;
    for (std::size_t at = svg.find(" id="); at != std::string::npos; at = svg.find(" id=", at + 1)) {
      ids.insert(svg.substr(at + 5, svg.find_first_of("'\"", at + 5) - at - 5));
      ++count;
    }
  }
  EXPECT_GT(count, 2u);
  EXPECT_EQ(ids.size(), count);
}

TEST(Draw, LeavesOutWhatHasNoPointToShow) {
  Drawing some = drawing({0, 1, 2}, {1, 2, 3}, "shown");
  some.panels.push_back(
      {.x_label = "x", .y_label = "gone", .curves = {{"lost", 0, Drawing::Mark::line, {0}, {nan}}}});
  some.panels[0].curves.push_back({"hidden", 1, Drawing::Mark::line, {0, 1}, {nan, nan}});
  Drawing logarithm = drawing({0, 1}, {0, -1});
  logarithm.panels[0].log_y = true;
  const auto figures = draw({drawing({}, {}), some, drawing({nan}, {1}), logarithm});
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_THAT(figures[0].svg, HasSubstr("shown"));
  for (const char* word : {"hidden", "gone", "lost"}) EXPECT_THAT(figures[0].svg, Not(HasSubstr(word)));
}

TEST(Draw, TakesAnyFiniteCurve) {
  Random random(3);
  std::vector<Drawing> drawings;
  for (int n = 0; n < 20; ++n) {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < 1 + random() % 20; ++i) {
      x.push_back(static_cast<double>(i));
      y.push_back(uniform(random, -1, 1) * std::pow(10.0, uniform(random, -100, 100)));
    }
    drawings.push_back(drawing(x, n % 2 == 0 ? y : std::vector<double>(x.size(), y[0])));
    drawings.back().panels[0].equal_scales = n % 3 == 0;
    drawings.back().panels[0].log_y = n % 3 == 1;
    if (n % 3 == 1) drawings.back().panels[0].curves[0].y[0] = 1.0;
  }
  EXPECT_EQ(draw(drawings).size(), drawings.size());
}

// gnuplot would take "inf" for a variable.
TEST(Draw, TakesWhatIsNoNumberForAGapWhereverItStands) {
  for (const double odd : {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                           nan, std::numeric_limits<double>::max(), -1e300}) {
    SCOPED_TRACE(odd);
    Drawing curve = drawing({0, odd, 2, 3}, {1, 2, odd, 4});
    Drawing::Panel& panel = curve.panels[0];
    panel.labels = {{odd, 1.0, "hidden"}, {1.0, odd, "hidden"}, {1.0, 1.0, "shown"}};
    panel.moments = {{odd, "hidden"}, {1.0, "then"}};
    panel.x_range = {0.0, odd};
    panel.y_range = {odd, 1.0};
    const auto figures = draw({curve});
    ASSERT_EQ(figures.size(), 1u);
    EXPECT_THAT(figures[0].svg,
                testing::AllOf(HasSubstr("shown"), HasSubstr("then"), Not(HasSubstr("hidden"))));
    for (const auto view :
         {Drawing::Grid::View::map, Drawing::Grid::View::surface, Drawing::Grid::View::cloud}) {
      Drawing some = field(view, 1.0);
      some.panels[0].grid.z[5] = odd;
      EXPECT_EQ(draw({some}).size(), 1u);
      some.panels[0].grid.x[5] = odd;
      EXPECT_EQ(draw({some}).size(), 1u) << "the other panel is drawn";
    }
    Drawing one = drawing({1e90}, {1e90});
    one.panels[0].equal_scales = std::isnan(odd);
    EXPECT_EQ(draw({one}).size(), 1u);
  }
}

TEST(Draw, ShowsAnyTextAsItIs) {
  const auto figures = draw({drawing({0, 1}, {1, 2}, "it's `date` @x $y {a_b} \\n \"q\" <b> & ψ")});
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_THAT(figures[0].svg, HasSubstr("it's `date` @x $y {a_b} \\n \"q\" &lt;b> &amp; ψ"));
}

TEST(Draw, ShowsAFieldAsColoursASurfaceOrPointsWithItsLabels) {
  using View = Drawing::Grid::View;
  for (const View view : {View::map, View::surface, View::cloud}) {
    for (const double height : {1.0, 0.0, -0.5}) {
      const auto figures = draw({field(view, height)});
      ASSERT_EQ(figures.size(), 1u);
      for (const char* words : {"x [m]", "y [m]", "z [m]", "panel's title"}) {
        EXPECT_THAT(figures[0].svg, HasSubstr(words)) << static_cast<int>(view);
      }
    }
  }
  EXPECT_THAT(draw({field(View::map, 1.0)})[0].svg, HasSubstr("<image"));
}

TEST(Draw, LeavesOutAFieldWithoutANumber) {
  EXPECT_TRUE(draw({field(Drawing::Grid::View::map, nan)}).empty());
}

TEST(Draw, NumbersThePicturesOfAPageOn) {
  EXPECT_NE(draw({drawing({0, 1}, {1, 2})}, 0)[0].svg, draw({drawing({0, 1}, {1, 2})}, 1)[0].svg);
}

TEST(Draw, SaysThatGnuplotIsMissing) {
  const std::string path = getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  try {
    draw({drawing({0, 1}, {1, 2})});
    ADD_FAILURE() << "drawn without gnuplot";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("gnuplot is missing"));
  }
  setenv("PATH", path.c_str(), 1);
}

TEST(Draw, NeedsNoGnuplotForNothing) { EXPECT_TRUE(draw({}).empty()); }

}  // namespace
}  // namespace sightline
