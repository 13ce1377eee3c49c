/// Two robots at a distance that a test chooses.
#pragma once

#include <utility>

#include "tests/support/random.hpp"

namespace sightline {

/// D [m] apart in a random direction.
inline std::pair<Sight<double>, Sight<double>> random_sights_apart(double D, Random& random) {
  const Sight<double> a = random_sight(random, 3);
  Sight<double> b = random_sight(random, 3);
  const Vec3<double> r = b.p - a.p;
  b.p = a.p + (D / norm(r)) * r;
  return {a, b};
}

}  // namespace sightline
