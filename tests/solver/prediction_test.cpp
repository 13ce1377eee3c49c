#include <gtest/gtest.h>

#include <cmath>

#include "sightline/solver.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

Sight<double> any_sight(Random& random) {
  const double psi = uniform(random, -3.1, 3.1);
  return {{random_point(random, 3.0), {std::cos(psi), std::sin(psi)}}, random_point(random, 1.0)};
}

Prediction random_prediction(Random& random, int sights) {
  Prediction prediction{.who = {0}, .time = uniform(random, 0, 9), .h = uniform(random, 0.01, 0.2)};
  for (int k = 0; k < sights; ++k) prediction.sights.push_back(any_sight(random));
  return prediction;
}

TEST(Prediction, AtTheTimeToldItSaysWhatWasToldBitForBit) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Prediction prediction = random_prediction(random, 21);
    for (int k = 0; k < 21; ++k) {
      const Sight<double> s = prediction.at(prediction.time, k),
                          expected = prediction.sights[static_cast<std::size_t>(k)];
      EXPECT_TRUE(same_bits(s.p.x, expected.p.x) && same_bits(s.d.y, expected.d.y) &&
                  same_bits(s.v.z, expected.v.z));
    }
  }
}

TEST(Prediction, ABodyThatKeepsItsVelocityIsOnItsLineAtAnyTime) {
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    Prediction prediction{.who = {0}, .time = uniform(random, 0, 9), .h = 0.05};
    const Sight<double> first = any_sight(random);
    for (int k = 0; k <= 20; ++k) {
      prediction.sights.push_back(first);
      prediction.sights.back().p = first.p + (0.05 * k) * first.v;
    }
    const double t = prediction.time + uniform(random, -0.9, 0.9);
    for (const int k : {0, 1, 7, 20}) {
      const Sight<double> s = prediction.at(t, k);
      const Vec3<double> p = first.p + (t - prediction.time + 0.05 * k) * first.v;
      EXPECT_LE(norm(s.p - p), 1e-12);
      EXPECT_LE(norm(s.v - first.v), 1e-14);
      EXPECT_NEAR(s.d.x, first.d.x, 1e-14);
    }
  }
}

TEST(Prediction, BetweenTwoSightsHeadingsStayOfLengthOneAndPositionsBetweenThem) {
  Random random(3);
  for (int trial = 0; trial < 500; ++trial) {
    const Prediction prediction = random_prediction(random, 2);
    const Sight<double> s = prediction.at(prediction.time + uniform(random, 0, 1) * prediction.h, 0);
    EXPECT_NEAR(std::hypot(s.d.x, s.d.y), 1.0, 1e-12);
    const double whole = norm(prediction.sights[1].p - prediction.sights[0].p);
    EXPECT_NEAR(norm(s.p - prediction.sights[0].p) + norm(prediction.sights[1].p - s.p), whole, 1e-12);
  }
  Prediction turned = random_prediction(random, 1);
  turned.sights.push_back(turned.sights[0]);
  turned.sights[1].d = {-turned.sights[0].d.x, -turned.sights[0].d.y};
  const Sight<double> half = turned.at(turned.time + 0.5 * turned.h, 0);
  EXPECT_NEAR(std::hypot(half.d.x, half.d.y), 1.0, 1e-12) << "headings that are opposite";
}

TEST(Prediction, ItHoldsForAsLongAsItReachesWhileTheBodyIsAboutThere) {
  Random random(4);
  Prediction prediction = random_prediction(random, 21);
  const double length = 21 * prediction.h;
  const auto holds = [&](double later, Vec3<double> off = {0, 0, 0}) {
    return prediction.holds(prediction.time + later, prediction.at(prediction.time + later, 0).p + off);
  };
  EXPECT_TRUE(holds(0.0));
  EXPECT_TRUE(holds(0.99 * length));
  EXPECT_TRUE(holds(-0.99 * length));
  EXPECT_FALSE(holds(1.01 * length));
  EXPECT_FALSE(holds(-1.01 * length));
  EXPECT_TRUE(holds(0.3 * length, {0, 0.99, 0}));
  EXPECT_FALSE(holds(0.3 * length, {0, 1.01, 0})) << "it is somewhere else";
  prediction.sights.clear();
  EXPECT_FALSE(prediction.holds(prediction.time, {0, 0, 0})) << "nothing is predicted";
}

TEST(Prediction, ANumberThatIsNotFiniteIsFoundWhereverItStands) {
  Random random(5);
  const Prediction prediction = random_prediction(random, 5);
  EXPECT_TRUE(prediction.is_finite());
  Prediction bad = prediction;
  bad.time = not_a_number;
  EXPECT_FALSE(bad.is_finite());
  for (std::size_t k = 0; k < 5; ++k) {
    for (double Vec3<double>::*component : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      bad = prediction;
      bad.sights[k].v.*component = not_a_number;
      EXPECT_FALSE(bad.is_finite());
      bad = prediction;
      bad.sights[k].p.*component = not_a_number;
      EXPECT_FALSE(bad.is_finite());
    }
  }
}

}  // namespace
}  // namespace sightline
