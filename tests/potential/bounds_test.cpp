#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

Sight<double> at(double x, double y, double z) { return {{{x, y, z}, {1.0, 0.0}}, {}}; }

TEST(AltitudeBand, OutsideTheWayBackIsDownhill) {
  Random random(1);
  for (int k = 0; k < 5000; ++k) {
    const AltitudeBand band{.z_min = 0.5, .z_max = 2.5, .kappa_A = uniform(random, 5, 20)};
    const double beyond = uniform(random, 0.0, 20.0);
    EXPECT_LT(band(at(0, 0, 2.5 + beyond)), band(at(0, 0, 2.6 + beyond)));
    EXPECT_LT(band(at(0, 0, 0.5 - beyond)), band(at(0, 0, 0.4 - beyond)));
  }
}

TEST(AltitudeBand, ItIsLowestInItsMiddleAndSymmetricAboutIt) {
  Random random(2);
  for (int k = 0; k < 5000; ++k) {
    const AltitudeBand band{.z_min = 0.5, .z_max = 2.5};
    const double off = uniform(random, 0.01, 5.0);
    EXPECT_LE(band(at(0, 0, 1.5)), band(at(0, 0, 1.5 + off)));
    EXPECT_NEAR(band(at(0, 0, 1.5 + off)), band(at(0, 0, 1.5 - off)), 1e-13);
  }
}

TEST(Geofence, IsTheSumOfABandInEachAxis) {
  Random random(3);
  for (int k = 0; k < 5000; ++k) {
    const Geofence box{.low = {-1, -2, 0.5}, .high = {1, 3, 2}};
    const Vec3<double> p = random_point(random, 5);
    double sum = 0, worst = -infinite;
    for (const auto& [low, high, v] : {std::array{-1.0, 1.0, p.x}, {-2.0, 3.0, p.y}, {0.5, 2.0, p.z}}) {
      const AltitudeBand band{.z_min = low, .z_max = high, .kappa_G = box.kappa_G, .kappa_A = box.kappa_A};
      sum += band(at(0, 0, v));
      worst = std::max(worst, band.violation(at(0, 0, v)));
    }
    EXPECT_NEAR(box(at(p.x, p.y, p.z)), sum, 1e-13);
    EXPECT_EQ(box.violation(at(p.x, p.y, p.z)), worst);
  }
}

TEST(Bounds, AnEmptyRegionIsRefused) {
  EXPECT_NE(refusal_of([] { AltitudeBand{.z_min = 2, .z_max = 2}.check(); }), "");
  EXPECT_NE(refusal_of([] { Geofence{.high = {10, -10, 5}}.check(); }), "");
}

}  // namespace
}  // namespace sightline
