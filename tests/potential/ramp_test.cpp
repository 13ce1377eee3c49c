#include <gtest/gtest.h>

#include "sightline/potential.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(Ramp, IsOneWhereNothingWasSaid) {
  for (const double t : {-1e9, 0.0, 1e9}) EXPECT_EQ(Ramp{}.at(t), 1.0);
}

TEST(Ramp, GoesOverWithoutAKinkAndHoldsItsEnds) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const Ramp ramp{uniform(random, 0, 50), uniform(random, 0.01, 5), uniform(random, 0, 1),
                    uniform(random, 0, 1)};
    EXPECT_EQ(ramp.at(ramp.begin - 1.0), ramp.from);
    EXPECT_EQ(ramp.at(ramp.begin), ramp.from);
    EXPECT_EQ(ramp.at(ramp.begin + ramp.duration), ramp.to);
    EXPECT_EQ(ramp.at(ramp.begin + ramp.duration + 1.0), ramp.to);
    EXPECT_NEAR(ramp.at(ramp.begin + ramp.duration / 2), (ramp.from + ramp.to) / 2, 1e-12);
    const double soon = 1e-4 * ramp.duration;
    EXPECT_NEAR(ramp.at(ramp.begin + soon), ramp.from, 1e-7);
    EXPECT_NEAR(ramp.at(ramp.begin + ramp.duration - soon), ramp.to, 1e-7);
    const double early = ramp.at(ramp.begin + 0.3 * ramp.duration),
                 late = ramp.at(ramp.begin + 0.6 * ramp.duration);
    EXPECT_EQ(early < late, ramp.from < ramp.to);
  }
}

TEST(Ramp, OfNoDurationIsAStep) {
  const Ramp step{.begin = 2.0, .duration = 0.0, .from = 0.0, .to = 1.0};
  EXPECT_EQ(step.at(1.999), 0.0);
  EXPECT_EQ(step.at(2.0), 1.0);
}

}  // namespace
}  // namespace sightline
