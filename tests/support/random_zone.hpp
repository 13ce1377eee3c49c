/// Random zones for tests of what keeps and judges them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/barrier.hpp"
#include "tests/support/random_polygon.hpp"

namespace sightline::test {

/// A convex polygon around the origin with corners on an ellipse of half axes of 0.5 to 2 times
/// `size` [m].
inline Polygon random_convex(Random& random, double size = 1.0) {
  const double a = size * uniform(random, 0.5, 2.0), b = size * uniform(random, 0.5, 2.0);
  for (;;) {
    std::vector<double> angles(3 + random() % 6);
    for (double& angle : angles) angle = uniform(random, 0.0, 2 * std::numbers::pi);
    std::sort(angles.begin(), angles.end());
    Polygon polygon;
    for (const double angle : angles) polygon.push_back({a * std::cos(angle), b * std::sin(angle)});
    if (expected_of_corners(polygon).empty()) return polygon;
  }
}

/// A zone of any polygon, side and heights, some of them without bounds.
inline Zone random_zone(Random& random) {
  Zone zone{.polygon = random_polygon(random, 3 + random() % 12, 5.0)};
  if (random() % 3 != 0) zone.from = uniform(random, -1.0, 1.0);
  if (random() % 3 != 0) zone.to = uniform(random, 1.5, 3.0);
  zone.keep = random() % 2 == 0 ? Zone::Keep::inside : Zone::Keep::outside;
  return zone;
}

}  // namespace sightline::test
