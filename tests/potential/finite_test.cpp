#include "sightline/potential/finite.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sightline/potential/distance.hpp"
#include "sightline/potential/region.hpp"
#include "sightline/potential/sensor_cone.hpp"

namespace sightline {
namespace {

TEST(NotFiniteAt, ThePaperSPotentialsAreFiniteEverywhere) {
  EXPECT_FALSE(not_finite_at(SensorCone{}));
  EXPECT_FALSE(not_finite_at(KeepOut{}));
  EXPECT_FALSE(not_finite_at(Cohesion{}));
}

TEST(NotFiniteAt, TheSpotIsOneWhereItIsNot) {
  for (const char* limit : {"sqrt(x * 1 m) < 2 m", "log(x / 1 m) < 1", "(x / 1 m)^0.3 < 2"}) {
    const Potential potential = Region(limit);
    const auto spot = not_finite_at(potential);
    ASSERT_TRUE(spot) << limit;
    EXPECT_FALSE(std::isfinite(potential(spot->observer, spot->target, spot->t))) << limit;
  }
}

TEST(NotFiniteAt, ACurvatureThatIsInfiniteOnAnAxisIsFound) {
  // 1/r_x is finite at random and infinite where both are level in x.
  EXPECT_TRUE(not_finite_at(Region("1 m / r_x < 2")));
  EXPECT_FALSE(not_finite_at(Region("1 m^2 / (r_x^2 + 1 m^2) < 2")));
}

TEST(NotFiniteAt, ASpotIsSaidWithItsUnits) {
  Spot spot;
  spot.observer.p = {1, 2, 3};
  spot.observer.d = spot.target.d = {1, 0};
  EXPECT_EQ(to_string(spot),
            "observer at (1, 2, 3) m heading (1, 0), target at (0, 0, 0) m heading (1, 0), t = 0 s");
}

}  // namespace
}  // namespace sightline
