#include "sightline/base/polygon.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random_polygon.hpp"

namespace sightline {
namespace {

using test::random_polygon;
using testing::HasSubstr;

constexpr int polygon_trials = 300;

std::size_t any_corner_count(Random& random) { return 3 + random() % 22; }

Vec2<double> any_point_of_plane(Random& random, double reach) {
  return {uniform(random, -reach, reach), uniform(random, -reach, reach)};
}

/// How many of the polygons have the point at least `deep` within.
int polygons_holding(const std::vector<Polygon>& polygons, const Vec2<double>& p, double deep) {
  return static_cast<int>(std::count_if(polygons.begin(), polygons.end(),
                                        [&](const Polygon& one) { return signed_distance(one, p) < -deep; }));
}

double area_of_polygons(const std::vector<Polygon>& polygons) {
  double sum = 0.0;
  for (const Polygon& one : polygons) sum += signed_area(one);
  return sum;
}

void expect_convex_polygon(const Polygon& p) {
  for (std::size_t i = 0; i < p.size(); ++i)
    EXPECT_GE(test::side_of(p[i], p[(i + 1) % p.size()], p[(i + 2) % p.size()]), -1e-9);
}

TEST(Polygon, ItsSignedDistanceHasTheSignOfWindingAndTheSizeOfASearch) {
  Random random(1);
  for (int trial = 0; trial < polygon_trials; ++trial) {
    const Polygon polygon = random_polygon(random, any_corner_count(random), 5.0);
    for (int k = 0; k < 40; ++k) {
      const Vec2<double> p = any_point_of_plane(random, 7.0);
      const double distance = signed_distance(polygon, p);
      EXPECT_EQ(distance < 0, test::winds_around(polygon, p)) << trial;
      EXPECT_NEAR(std::abs(distance), test::searched_distance(polygon, p), 1e-9) << trial;
    }
  }
}

TEST(Polygon, ItsOrientationChangesTheSignOfItsAreaAlone) {
  Random random(2);
  for (int trial = 0; trial < polygon_trials; ++trial) {
    const Polygon polygon = random_polygon(random, any_corner_count(random), 5.0);
    Polygon reversed = polygon;
    std::reverse(reversed.begin(), reversed.end());
    const Vec2<double> p = any_point_of_plane(random, 7.0);
    EXPECT_NEAR(signed_area(reversed), -signed_area(polygon), 1e-9);
    EXPECT_NEAR(signed_distance(reversed, p), signed_distance(polygon, p), 1e-12);
    EXPECT_NEAR(area_of_polygons(convex_pieces(reversed)), std::abs(signed_area(polygon)), 1e-8);
    EXPECT_NEAR(signed_area(convex_hull(reversed)), signed_area(convex_hull(polygon)), 1e-9);
  }
  EXPECT_NEAR(signed_area(Polygon{{1, 1}, {3, 1}, {3, 4}, {1, 4}}), 6.0, 1e-12);
}

// At most two diagonals are essential at each reflex corner.
TEST(Polygon, ItsPiecesAreConvexCoverItOnceAndAreFew) {
  Random random(3);
  for (int trial = 0; trial < polygon_trials; ++trial) {
    const Polygon polygon = random_polygon(random, any_corner_count(random), 5.0);
    const std::vector<Polygon> pieces = convex_pieces(polygon);
    for (const Polygon& piece : pieces) {
      expect_convex_polygon(piece);
      EXPECT_GT(signed_area(piece), 0.0) << trial;
    }
    EXPECT_NEAR(area_of_polygons(pieces), std::abs(signed_area(polygon)), 1e-8) << trial;
    const double side = signed_area(polygon) > 0 ? 1.0 : -1.0;
    std::size_t reflex = 0;
    for (std::size_t i = 0, n = polygon.size(); i < n; ++i)
      reflex += side * test::side_of(polygon[i], polygon[(i + 1) % n], polygon[(i + 2) % n]) < 0 ? 1U : 0U;
    EXPECT_LE(pieces.size(), 2 * reflex + 1) << trial;
    for (int k = 0; k < 40; ++k) {
      const Vec2<double> p = any_point_of_plane(random, 6.0);
      if (signed_distance(polygon, p) > 1e-9) {
        EXPECT_EQ(polygons_holding(pieces, p, 1e-9), 0) << trial;
      }
      EXPECT_LE(polygons_holding(pieces, p, 1e-9), 1) << trial;
      if (signed_distance(polygon, p) < -1e-9) {
        EXPECT_GE(polygons_holding(pieces, p, -1e-9), 1) << trial;
      }
    }
  }
}

TEST(Polygon, ItsHullIsItselfAndItsPockets) {
  Random random(4);
  for (int trial = 0; trial < polygon_trials; ++trial) {
    const Polygon polygon = random_polygon(random, any_corner_count(random), 5.0),
                  hull = convex_hull(polygon);
    const std::vector<Polygon> all = pockets(polygon);
    expect_convex_polygon(hull);
    for (const Vec2<double>& corner : polygon) EXPECT_LE(signed_distance(hull, corner), 1e-9);
    EXPECT_NEAR(area_of_polygons(all) + std::abs(signed_area(polygon)), signed_area(hull), 1e-8) << trial;
    for (int k = 0; k < 40; ++k) {
      const Vec2<double> p = any_point_of_plane(random, 6.0);
      if (std::abs(signed_distance(hull, p)) < 1e-6 || std::abs(signed_distance(polygon, p)) < 1e-6) continue;
      const int in_hull = signed_distance(hull, p) < 0 ? 1 : 0,
                in_it = signed_distance(polygon, p) < 0 ? 1 : 0;
      EXPECT_EQ(polygons_holding(all, p, 0.0) + in_it, in_hull) << trial;
    }
  }
}

TEST(Polygon, ARectangleIsOnePieceAndRoomsOfAnLAndAUHaveFew) {
  const Polygon box = {{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}};  // with a corner amid an edge
  EXPECT_EQ(convex_pieces(box).size(), 1U);
  EXPECT_TRUE(pockets(box).empty());
  EXPECT_LE(convex_pieces(test::l_room).size(), 3U);
  ASSERT_EQ(pockets(test::l_room).size(), 1U);
  EXPECT_NEAR(signed_area(pockets(test::l_room)[0]), 8.0, 1e-9);
  EXPECT_LE(convex_pieces(test::u_room).size(), 5U);
  ASSERT_EQ(pockets(test::u_room).size(), 1U);
  EXPECT_NEAR(signed_area(pockets(test::u_room)[0]), 9.0, 1e-9);
}

TEST(Polygon, CornersInAnyOrderAreRefusedWhereEdgesCross) {
  Random random(5);
  int simple = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Polygon p = test::random_corners(random, 4 + random() % 4, 5.0);
    const std::size_t n = p.size();
    bool crosses = false;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 2; j < n; ++j)
        crosses = crosses || test::cross(p[i], p[i + 1], p[j], p[(j + 1) % n]);
    const std::string expected = expected_of_corners(p);
    if (crosses) {
      EXPECT_THAT(expected, HasSubstr("neither cross nor touch"));
    }
    simple += expected.empty() ? 1 : 0;
  }
  EXPECT_GT(simple, 300);
}

TEST(Polygon, ARefusalSaysWhatWasExpected) {
  EXPECT_EQ(expected_of_corners(Polygon{{0, 0}, {1, 0}}), "at least 3 corners");
  EXPECT_EQ(expected_of_corners(Polygon{{0, 0}, {2, 2}, {2, 0}, {0, 2}}),
            "edges that neither cross nor touch (to 0.001 m), edge 0 meets edge 2");
  EXPECT_EQ(expected_of_corners(Polygon{{0, 0}, {1, 1}, {2, 2}}), "an area, its corners are on one line");
  // A corner that comes back to an edge, one that is there twice, and an edge without a width.
  EXPECT_THAT(expected_of_corners(Polygon{{0, 0}, {4, 0}, {4, 3}, {2, 0.0005}, {0, 3}}),
              HasSubstr("edge 0 meets edge 2"));
  EXPECT_THAT(expected_of_corners(Polygon{{0, 0}, {4, 0}, {4, 0}, {4, 3}, {0, 3}}), HasSubstr("meets"));
  EXPECT_THAT(expected_of_corners(Polygon{{0, 0}, {4, 0}, {4, 3}, {2, 3}, {2, 5}, {2, 3}, {0, 3}}),
              HasSubstr("meets"));
  EXPECT_EQ(expected_of_corners(test::l_room), "");
}

}  // namespace
}  // namespace sightline
