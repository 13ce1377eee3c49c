#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sightline/report.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using nlohmann::json;
using View = Drawing::Grid::View;

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

Drawing field(View view, double height) {
  Drawing::Panel panel{.x_label = "x [m]", .y_label = "y [m]"};
  panel.height = 200;
  panel.title = "panel's title";
  panel.grid = {.view = view, .across = 4, .label = "z [m]"};
  for (int i = 0; i < 12; ++i) {
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

/// Panels of a drawing as its page has them; none if the drawing is left out.
json panels_of(Drawing drawing) {
  std::vector<Drawing> drawings = {std::move(drawing)};
  prune(drawings);
  return drawings.empty() ? json::array() : json::parse(to_json(drawings[0])).at("panels");
}

TEST(Figures, ACurveIsItsPointsToSevenDigitsWithNullForAGap) {
  Random random(3);
  std::vector<double> x = walk(random, 200), y = walk(random, 200);
  for (int n = 0; n < 20; ++n) y[random() % 200] = nan;
  const json curve = panels_of(drawing(x, y))[0]["curves"][0];
  EXPECT_EQ(curve["label"], "y");
  EXPECT_EQ(curve["colour"], palette[0]);
  EXPECT_EQ(curve["mark"], "line");
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(curve["x"][i].get<double>(), x[i], 1e-6 * std::abs(x[i]));
    ASSERT_EQ(curve["y"][i].is_null(), std::isnan(y[i]));
    if (!std::isnan(y[i])) {
      EXPECT_NEAR(curve["y"][i].get<double>(), y[i], 1e-6 * std::abs(y[i]));
    }
  }
}

TEST(Figures, WhatHasNoPointToShowIsLeftOut) {
  Drawing some = drawing({0, 1, 2}, {1, 2, 3}, "shown");
  some.panels.push_back(
      {.x_label = "x", .y_label = "gone", .curves = {{"lost", 0, Drawing::Mark::line, {0}, {nan}}}});
  some.panels[0].curves.push_back({"hidden", 1, Drawing::Mark::line, {0, 1}, {nan, nan}});
  const json panels = panels_of(some);
  ASSERT_EQ(panels.size(), 1U);
  ASSERT_EQ(panels[0]["curves"].size(), 1U);
  EXPECT_EQ(panels[0]["curves"][0]["label"], "shown");
  Drawing logarithm = drawing({0, 1}, {0, -1});
  logarithm.panels[0].log_y = true;
  for (const Drawing& none : {drawing({}, {}), drawing({nan}, {1}), logarithm, field(View::map, nan)})
    EXPECT_TRUE(panels_of(none).empty());
}

TEST(Figures, WhatIsNoNumberIsAGapWhereverItStands) {
  for (const double odd : {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                           nan, std::numeric_limits<double>::max(), -1e300}) {
    SCOPED_TRACE(odd);
    Drawing curve = drawing({0, odd, 2, 3}, {1, 2, odd, 4});
    Drawing::Panel& panel = curve.panels[0];
    panel.labels = {{odd, 1.0, "hidden"}, {1.0, odd, "hidden"}, {1.0, 1.0, "shown"}};
    panel.moments = {{odd, "hidden"}, {1.0, "then"}};
    panel.x_range = {0.0, odd};
    panel.y_range = {odd, 1.0};
    const json shown = panels_of(curve)[0];
    EXPECT_EQ(shown["curves"][0]["y"], (json{1.0, nullptr, nullptr, 4.0}));
    EXPECT_EQ(shown["notes"].size(), 1U);
    EXPECT_EQ(shown["moments"].size(), 1U);
    EXPECT_TRUE(shown["xRange"].is_null() && shown["yRange"].is_null());
    for (const View view : {View::map, View::surface, View::cloud}) {
      Drawing some = field(view, 1.0);
      some.panels[0].grid.z[5] = odd;
      EXPECT_TRUE(panels_of(some)[0]["grid"]["z"][5].is_null());
      some.panels[0].grid.x[5] = odd;
      EXPECT_EQ(panels_of(some).size(), 1U) << "the other panel is drawn";
    }
  }
}

TEST(Figures, AnyTextStaysWithinItsElementAndIsAsItWas) {
  const std::string text = "it's `date` \\n \"q\" </script> & ψ";
  const Drawing some = drawing({0, 1}, {1, 2}, text);
  EXPECT_THAT(to_json(some), testing::Not(testing::HasSubstr("<")));
  EXPECT_EQ(panels_of(some)[0]["curves"][0]["label"], text);
}

TEST(Figures, AFieldHasTheXOfARowAndTheYOfAColumnAndACloudAllOfIts) {
  for (const View view : {View::map, View::surface, View::cloud}) {
    const json grid = panels_of(field(view, 2.0))[0]["grid"];
    const std::size_t rows = view == View::cloud ? 12 : 3, columns = view == View::cloud ? 12 : 4;
    EXPECT_EQ(grid["x"].size(), columns);
    EXPECT_EQ(grid["y"].size(), rows);
    EXPECT_EQ(grid["z"].size(), 12U);
    EXPECT_EQ(grid["x"].back(), 3.0);
    EXPECT_EQ(grid["y"].back(), 2.0);
    EXPECT_EQ(grid["label"], "z [m]");
  }
}

}  // namespace
}  // namespace sightline
