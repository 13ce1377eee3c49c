/// Random simple polygons, and what tests know of polygons without the code under test.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "sightline/base/polygon.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

inline double side_of(const Vec2<double>& a, const Vec2<double>& b, const Vec2<double>& c) {
  return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
}

/// Whether two edges cross at a point inside both.
inline bool cross(const Vec2<double>& a, const Vec2<double>& b, const Vec2<double>& c,
                  const Vec2<double>& d) {
  return side_of(a, b, c) * side_of(a, b, d) < 0 && side_of(c, d, a) * side_of(c, d, b) < 0;
}

/// n corners anywhere within `reach` of the origin in each axis [m], in any order.
inline Polygon random_corners(Random& random, std::size_t n, double reach) {
  Polygon corners(n);
  for (Vec2<double>& p : corners) p = {uniform(random, -reach, reach), uniform(random, -reach, reach)};
  return corners;
}

/// A simple polygon of n such corners, of either orientation. Reversing what lies between two edges
/// that cross makes the polygon shorter, until none cross.
inline Polygon random_polygon(Random& random, std::size_t n, double reach) {
  for (;;) {
    Polygon p = random_corners(random, n, reach);
    for (bool crossed = true; crossed;) {
      crossed = false;
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 2; j < n; ++j) {
          if ((j + 1) % n == i || !cross(p[i], p[i + 1], p[j], p[(j + 1) % n])) continue;
          std::reverse(p.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                       p.begin() + static_cast<std::ptrdiff_t>(j) + 1);
          crossed = true;
        }
      }
    }
    if (expected_of_corners(p).empty()) return p;
  }
}

/// Whether a point is inside, by the angle that the boundary turns about it.
inline bool winds_around(Corners polygon, const Vec2<double>& p) {
  double angle = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2<double>&a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const Vec2<double> r = {a.x - p.x, a.y - p.y}, s = {b.x - p.x, b.y - p.y};
    angle += std::atan2(r.x * s.y - r.y * s.x, r.x * s.x + r.y * s.y);
  }
  return std::abs(angle) > std::numbers::pi;
}

/// Distance to the boundary by a search along each edge [m].
inline double searched_distance(Corners polygon, const Vec2<double>& p) {
  double least = infinity;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2<double>&a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const auto at = [&](double s) {
      return std::hypot(a.x + s * (b.x - a.x) - p.x, a.y + s * (b.y - a.y) - p.y);
    };
    double from = 0.0, to = 1.0;
    for (int round = 0; round < 80; ++round) {
      const double third = (to - from) / 3;
      if (at(from + third) < at(to - third))
        to -= third;
      else
        from += third;
    }
    least = std::min({least, at(0.0), at(0.5 * (from + to)), at(1.0)});
  }
  return least;
}

/// Rooms in the form of an L and of a U [m].
inline const Polygon l_room = {{0, 0}, {6, 0}, {6, 2}, {2, 2}, {2, 6}, {0, 6}};
inline const Polygon u_room = {{0, 0}, {9, 0}, {9, 6}, {6, 6}, {6, 3}, {3, 3}, {3, 6}, {0, 6}};

}  // namespace sightline::test
