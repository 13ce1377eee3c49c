#include "sightline/campaign/success_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

namespace sightline {
namespace {

using std::numbers::pi;

std::int64_t runs(const SuccessMap& map) {
  return std::accumulate(map.cells.begin(), map.cells.end(), map.behind.runs,
                         [](std::int64_t sum, const SuccessMap::Cell& cell) { return sum + cell.runs; });
}

TEST(SuccessMap, EveryStartIsCountedOnceWhereverItIs) {
  SuccessMap map{.range_max = 6.0};
  std::int64_t count = 0;
  for (const double range : {0.0, 0.3, 1.0, 5.999, 6.0, 7.0}) {
    for (double bearing = -20.0; bearing < 20.0; bearing += 0.1) {
      map.add(range, bearing, {1, 0});
      EXPECT_EQ(runs(map), ++count);
    }
  }
  map.add(1.0, pi, {2, 1});
  EXPECT_EQ(map.behind.runs, 2);
  EXPECT_EQ(map.behind.recovered, 1);
}

TEST(SuccessMap, ASectorHasTheBearingsOfItsPlaceAndWholeTurnsDoNotMatter) {
  for (int sector = 0; sector < SuccessMap::sectors; ++sector) {
    SuccessMap map{.range_max = 6.0};
    const double bearing = 2 * pi * (sector + 0.5) / SuccessMap::sectors - pi;
    for (const double turn : {0.0, 2 * pi, -4 * pi}) map.add(2.5, bearing + turn, {1, 1});
    EXPECT_EQ(map.cells[static_cast<std::size_t>(2 * SuccessMap::sectors + sector)].runs, 3) << sector;
  }
}

TEST(SuccessMap, ThePictureTellsTheNumbersOfEachCellThatHasAny) {
  SuccessMap map{.range_max = 6.0};
  map.add(0.5, 0.1, {4, 3});
  map.add(2.5, -0.1, {7, 7});
  map.add(1.0, pi, {2, 0});
  const std::string svg = to_svg(map, "a <b>");
  EXPECT_THAT(svg, testing::HasSubstr("0.0 to 1.0 m, 0 to 15°: 3 of 4 recovered"));
  EXPECT_THAT(svg, testing::HasSubstr("2.0 to 3.0 m, -15 to 0°: 7 of 7 recovered"));
  EXPECT_THAT(svg, testing::HasSubstr("exactly behind: 0 of 2 recovered"));
  EXPECT_THAT(svg, testing::HasSubstr("a &lt;b&gt;"));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("nan")));
}

TEST(SuccessMap, AllNoneAndSomeRecoveredHaveColoursOfTheirOwn) {
  std::vector<std::string> pictures;
  for (const std::int64_t good : {0, 25, 50, 99, 100}) {
    SuccessMap map{.range_max = 6.0};
    map.add(0.5, 0.1, {100, good});
    const std::string svg = to_svg(map, "a");
    pictures.push_back(svg.substr(svg.find("<path fill="), 21));
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(pictures[i], pictures[j]);
  }
}

}  // namespace
}  // namespace sightline
