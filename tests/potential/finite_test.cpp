#include "sightline/potential/finite.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sightline/potentials.hpp"

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

TEST(NotFiniteAt, AFormulaThatEndsWithinTheFlightIsFoundWithItsTime) {
  const Potential ends = Region("sqrt((150 s - t) / 1 s) > 0 - distance / 1 m");
  EXPECT_FALSE(not_finite_at(ends, {.until = 149.0}));
  const auto spot = not_finite_at(ends, {.until = 151.0, .period = 0.01});
  ASSERT_TRUE(spot && spot->ends);
  EXPECT_NEAR(*spot->ends, 150.0, 1e-6);
  EXPECT_NE(to_string(*spot).find("finite until t = 150 s"), std::string::npos) << to_string(*spot);
}

TEST(NotFiniteAt, ASinglePeriodInWhichAFormulaIsNoNumberIsFound) {
  const Potential pole = Region("distance / 1 m > 1 s / (t - 40.37 s)");
  EXPECT_TRUE(not_finite_at(pole, {.until = 60.0, .period = 0.01}));
}

TEST(NotFiniteAt, PlacesAroundTheTeamAreLookedAtWhereverItIs) {
  const Potential wall = Region("sqrt((500 m - target.p_x) / 1 m) > distance / 1 m");
  EXPECT_FALSE(not_finite_at(wall));
  EXPECT_TRUE(not_finite_at(wall, {.centre = {490.0, 0.0, 0.0}}));
}

TEST(NotFiniteAt, TheThirdBodyMayBeWhereItIsNot) {
  for (const char* limit :
       {"sqrt((third.p_x - observer.p_x) * 1 m) < 2 m", "1 m^2 / (third.p_y - target.p_y) < 2 m"}) {
    const Potential potential = Region(limit);
    const auto spot = not_finite_at(potential);
    ASSERT_TRUE(spot && spot->third) << limit;
    EXPECT_NE(to_string(*spot).find(", third body at ("), std::string::npos);
  }
  const auto spot = not_finite_at(Region("sqrt(x * 1 m) < 2 m"));
  ASSERT_TRUE(spot);
  EXPECT_FALSE(spot->third);
}

}  // namespace
}  // namespace sightline
