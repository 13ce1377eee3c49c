#include <gtest/gtest.h>

#include <cmath>

#include "sightline/potential.hpp"
#include "tests/support/difference.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(UnitStep, IsOneWhereTheLimitIsViolatedAndZeroWhereItIsMet) {
  Random random(1);
  const UnitStep eps;
  for (int k = 0; k < 10'000; ++k) {
    const double c = random_finite(random);
    EXPECT_EQ(eps(c), c > 0 ? 1.0 : 0.0);
  }
  EXPECT_EQ(eps(0.0), 0.0);
  EXPECT_EQ(eps(-0.0), 0.0);
}

TEST(SigmoidStep, RisesWithItsArgumentBetweenZeroAndOne) {
  Random random(2);
  for (int k = 0; k < 10'000; ++k) {
    const SigmoidStep sig{std::exp(uniform(random, -3, 5))};
    const double a = uniform(random, -3, 3), b = uniform(random, -3, 3);
    EXPECT_LE(sig(std::min(a, b)), sig(std::max(a, b)) * (1 + 1e-15));
    EXPECT_GT(sig(a), 0.0);
    EXPECT_LE(sig(a), 1.0);
    EXPECT_EQ(sig(0.0), 0.5);
    EXPECT_NEAR(sig(a) + sig(-a), 1.0, 2.3e-16);
  }
}

TEST(SigmoidStep, TendsToTheUnitStepAsKappaAGrows) {
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const double c = uniform(random, -3, 3);
    double before = std::fabs(SigmoidStep{0.01}(c)-UnitStep{}(c));
    for (double kappa_A = 0.1; kappa_A < 1e12; kappa_A *= 10) {
      const double now = std::fabs(SigmoidStep{kappa_A}(c)-UnitStep{}(c));
      EXPECT_LE(now, before);
      before = now;
    }
    EXPECT_LE(before, 1e-15) << c;  // (37)
  }
}

TEST(SigmoidStep, ItsDerivativeIsKappaATimesSTimesOneMinusS) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const double kappa_A = uniform(random, 0.1, 5);
    const std::array c = {uniform(random, -3, 3)};
    const auto sig = [&](const std::vector<Wide>& x) { return SigmoidStep{kappa_A}(x[0]); };
    const double s = SigmoidStep{kappa_A}(c[0]);
    EXPECT_LE(relative_error(kappa_A * s * (1 - s), CentralDifference(sig, c).first(0)),
              1e-11);  // (36), mended
  }
  // (36) as printed has the numerator kappa_A (1 + e^(-kappa_A c)): 1.291 at c = 0.3, kappa_A = 2.
  const double s = SigmoidStep{2.0}(0.3);
  EXPECT_NEAR(2.0 * s * (1 - s), 0.458, 5e-4);
  EXPECT_NEAR(2.0 * s, 1.291, 5e-4);
}

}  // namespace
}  // namespace sightline
