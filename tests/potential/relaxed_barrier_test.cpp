#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sightline/formula.hpp"
#include "sightline/potential.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

/// c itself is the height of the robot.
struct Height {
  template <class S>
  S operator()(const Sight<S>& robot) const {
    return robot.p.z;
  }
};

/// B, B' and B'' as the graph has them.
class Curve {
 public:
  explicit Curve(const RelaxedBarrier& barrier) {
    Graph graph;
    const Term c = graph.input(0);
    const Term value = barrier.of(Symbol(graph, c)).in(graph);
    const Derivatives d = derive(graph, value, std::vector{c});
    program_ = Program(graph, std::vector{value, d.first[0], d.second[0]}, 1);
  }
  std::vector<double> operator()(double c) const { return evaluate(program_, std::vector{c}); }

 private:
  Program program_;
};

TEST(RelaxedBarrier, InsideItIsALogarithmAndBeyondTheParabolaOfFellerAndEbenbauer) {
  Random random(1);
  for (int k = 0; k < 20'000; ++k) {
    const double mu = uniform(random, 0.001, 2), delta = uniform(random, 0.01, 3), c = uniform(random, -5, 5);
    const double w = (-c - 2 * delta) / delta;
    const double expected = -c >= delta ? -mu * std::log(-c) : mu / 2 * (w * w - 1) - mu * std::log(delta);
    EXPECT_LE(relative_error(RelaxedBarrier{Height{}, mu, delta}.of(c), expected), 1e-12) << c;
  }
}

TEST(RelaxedBarrier, ValueSlopeAndCurvatureHaveNoJumpWhereTheBranchesMeet) {
  for (const double delta : {0.01, 0.1, 1.0}) {
    const Curve curve({Height{}, 0.3, delta});
    const double gap = 1e-9 * delta;
    const auto inside = curve(-delta - gap), outside = curve(-delta + gap);
    EXPECT_NEAR(inside[0], -0.3 * std::log(delta), 1e-8);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_LE(relative_error(inside[i], outside[i]), 1e-8) << i;
    EXPECT_LE(relative_error(inside[1], 0.3 / delta), 1e-8);
    EXPECT_LE(relative_error(inside[2], 0.3 / (delta * delta)), 1e-8);
  }
}

TEST(RelaxedBarrier, SlopeAndCurvatureAreThoseOfTheValueByCentralDifferences) {
  Random random(2);
  for (int k = 0; k < 5'000; ++k) {
    const double delta = uniform(random, 0.05, 1), c = uniform(random, -5, 5), step = 1e-4 * delta;
    if (std::fabs(-c - delta) < 3 * step) continue;  // the third derivative jumps there
    const RelaxedBarrier barrier{Height{}, 0.3, delta};
    const auto here = Curve(barrier)(c), left = Curve(barrier)(c - step), right = Curve(barrier)(c + step);
    const double scale = 0.3 / delta;
    EXPECT_NEAR((right[0] - left[0]) / (2 * step), here[1], 1e-6 * std::max(scale, std::fabs(here[1])));
    EXPECT_NEAR((right[1] - left[1]) / (2 * step), here[2], 1e-6 * std::max(scale / delta, here[2]));
  }
}

TEST(RelaxedBarrier, ItRisesTowardsTheLimitAndIsConvexHoweverFarBeyond) {
  Random random(3);
  const Curve curve({Height{}, 0.02, 0.1});
  for (int k = 0; k < 20'000; ++k) {
    const double c = (random() % 2 == 0 ? -1 : 1) * std::pow(10.0, uniform(random, -6, 6));
    const auto at = curve(c);
    EXPECT_TRUE(std::isfinite(at[0])) << c;
    EXPECT_GT(at[1], 0.0) << c;
    EXPECT_GT(at[2], 0.0) << c;
  }
}

TEST(RelaxedBarrier, WhatIsNotANumberIsNotHidden) {
  const auto at = Curve({Height{}, 0.02, 0.1})(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(std::isnan(at[0]) && std::isnan(at[1]));
}

TEST(RelaxedBarrier, AWeightOrAWidthThatIsNotPositiveIsRefused) {
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    const auto sentence = [](const RelaxedBarrier& barrier) { return refusal_of([&] { barrier.check(); }); };
    EXPECT_THAT(sentence({SpeedLimit{}, bad, 0.1}), HasSubstr("speed.mu = "));
    EXPECT_THAT(sentence({SpeedLimit{}, 0.1, bad}), HasSubstr("speed.delta = "));
    EXPECT_EQ(sentence({SpeedLimit{}, 0.1, 0.1}), "");
  }
}

}  // namespace
}  // namespace sightline
