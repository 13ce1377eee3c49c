#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

constexpr double deg = pi / 180;

Vec2<double> direction(double psi, double length = 1.0) {
  return {length * std::cos(psi), length * std::sin(psi)};
}

/// The angle to the left, in (-pi, pi].
double angle(const Vec2<double>& from, const Vec2<double>& to) {
  return std::atan2(from.x * to.y - from.y * to.x, from.x * to.x + from.y * to.y);
}

/// Of a robot whose states all have a weight.
HeadingErrorLimit limit_of(const Model& model) {
  return {model, std::vector<double>(static_cast<std::size_t>(model.nx()), 1.0), {}};
}

/// A reference of a Multirotor over some stages, as a robot of that heading sees it.
std::vector<Vec2<double>> seen(double heading, const std::vector<Vec2<double>>& reference,
                               bool* turned = nullptr) {
  constexpr std::ptrdiff_t nx = Multirotor::nx, at = Multirotor::heading_at;
  static const HeadingErrorLimit limit = limit_of(Multirotor{});
  const Vec2<double> d = direction(heading);
  const std::vector<double> x = {1, 2, 3, d.x, d.y, 0.1, 0.2};
  std::vector<double> x_ref(reference.size() * nx, 7.0);
  for (std::size_t k = 0; k < reference.size(); ++k)
    x_ref[k * nx + at] = reference[k].x, x_ref[k * nx + at + 1] = reference[k].y;
  const bool any = limit(x.data(), 1, x_ref.data(), static_cast<int>(reference.size()), nx, 1);
  if (turned != nullptr) *turned = any;
  std::vector<Vec2<double>> result;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    for (std::size_t i = 0; i < nx; ++i) {
      if (i != at && i != at + 1) {
        EXPECT_EQ(x_ref[k * nx + i], 7.0);
      }
    }
    result.push_back({x_ref[k * nx + at], x_ref[k * nx + at + 1]});
  }
  return result;
}

TEST(HeadingErrorLimit, UpTo120DegreesNotABitChanges) {
  Random random(1);
  for (int n = 0; n < 20000; ++n) {
    const double heading = uniform(random, -pi, pi), e = uniform(random, -119.999, 119.999) * deg;
    const Vec2<double> d = direction(heading + e, uniform(random, 0.1, 3.0));
    bool turned = true;
    const Vec2<double> now = seen(heading, {d}, &turned)[0];
    EXPECT_FALSE(turned);
    EXPECT_EQ(now.x, d.x);
    EXPECT_EQ(now.y, d.y);
  }
}

TEST(HeadingErrorLimit, BeyondTheReferenceIsSeen120DegreesOffOnTheShorterSideAndAsLong) {
  Random random(2);
  for (int n = 0; n < 20000; ++n) {
    const double heading = uniform(random, -pi, pi), e = uniform(random, 120.001, 174.999) * deg,
                 length = uniform(random, 0.1, 3.0);
    for (const double side : {1.0, -1.0}) {
      const Vec2<double> now = seen(heading, {direction(heading + side * e, length)})[0];
      EXPECT_NEAR(angle(direction(heading), now), side * 120 * deg, 1e-12);
      EXPECT_NEAR(std::hypot(now.x, now.y), length, 1e-12);
    }
  }
}

TEST(HeadingErrorLimit, OppositeItIsToTheLeftWhateverTheRounding) {
  for (const double heading : {0.0, 0.3, pi / 2, -2.0, pi, -pi}) {
    for (const double off : {0.0, 1e-16, -1e-16, 1e-9, -1e-9, 1e-3, -1e-3, 4.9 * deg, -4.9 * deg}) {
      for (const double half : {pi, -pi}) {
        const Vec2<double> now = seen(heading, {direction(heading + half + off)})[0];
        EXPECT_NEAR(angle(direction(heading), now), 120 * deg, 1e-12) << heading << " " << off << " " << half;
        EXPECT_NEAR(heading_error(direction(heading), direction(heading + half + off)), pi + off, 1e-12);
      }
    }
    EXPECT_LT(angle(direction(heading), seen(heading, {direction(heading + pi + 5.1 * deg)})[0]), 0);
  }
}

TEST(HeadingErrorLimit, TheErrorOfOtherHeadingsIsTheShorterWay) {
  for (double e = -174.9; e < 175; e += 0.7)
    EXPECT_NEAR(heading_error(direction(1.0), direction(1.0 + e * deg)), e * deg, 1e-14);
}

TEST(HeadingErrorLimit, WhatIsSeenIsContinuousButForTheOneChoiceOfTheSide) {
  constexpr double step = 0.01;
  int jumps = 0;
  for (double e = -180; e < 180; e += step) {
    const Vec2<double> a = seen(0.4, {direction(0.4 + e * deg)})[0],
                       b = seen(0.4, {direction(0.4 + (e + step) * deg)})[0];
    const double change = std::abs(angle(a, b));
    if (change <= 1.001 * step * deg) continue;
    ++jumps;
    EXPECT_NEAR(e, -175, 2 * step);
  }
  EXPECT_EQ(jumps, 1);
}

TEST(HeadingErrorLimit, AMovingReferenceMovesOnAsItDoes) {
  std::vector<Vec2<double>> reference;
  for (int k = 0; k <= 20; ++k) reference.push_back(direction(2.8 + 0.2 * k));
  const std::vector<Vec2<double>> now = seen(0.0, reference);
  for (std::size_t k = 0; k < now.size(); ++k)
    EXPECT_NEAR(angle(direction(120 * deg + 0.2 * static_cast<double>(k)), now[k]), 0.0, 1e-12);
  // One that it has caught up with is seen as it is, however far it turns within the horizon.
  const std::vector<Vec2<double>> caught_up = seen(2.0, reference);
  for (std::size_t k = 0; k < now.size(); ++k) EXPECT_EQ(caught_up[k].x, reference[k].x);
}

TEST(HeadingErrorLimit, AJumpAlongTheHorizonIsSeen120DegreesFromWhereItWas) {
  const Vec2<double> first = direction(0.2), opposite = direction(0.2 + pi), back = direction(0.3);
  const std::vector<Vec2<double>> now = seen(0.0, {first, first, opposite, opposite, back});
  EXPECT_EQ(now[1].x, first.x);
  EXPECT_NEAR(angle(first, now[2]), 120 * deg, 1e-12);
  EXPECT_NEAR(angle(now[2], now[3]), 0.0, 1e-12);
  EXPECT_EQ(now[4].x, back.x);
  EXPECT_EQ(now[4].y, back.y);
  // Through no heading at all, as where two opposite references are blended.
  const std::vector<Vec2<double>> blended =
      seen(0.2, {first, direction(0.2, 0.1), {0, 0}, direction(0.2 + pi, 0.1), opposite});
  EXPECT_EQ(blended[2].x, 0.0);
  EXPECT_NEAR(angle(first, blended[3]), 120 * deg, 1e-12);
  EXPECT_NEAR(angle(first, blended[4]), 120 * deg, 1e-12);
  EXPECT_NEAR(std::hypot(blended[3].x, blended[3].y), 0.1, 1e-15);
}

TEST(HeadingErrorLimit, NoHeadingAndNoNumberStayWhatTheyAre) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  bool turned = true;
  const Vec2<double> none = seen(1.0, {{0.0, 0.0}}, &turned)[0];
  EXPECT_FALSE(turned);
  EXPECT_EQ(none.x, 0.0);
  EXPECT_TRUE(std::isnan(seen(1.0, {{nan, -1.0}}, &turned)[0].x));
  EXPECT_FALSE(turned);
  EXPECT_EQ(seen(nan, {{-1.0, 0.5}}, &turned)[0].y, 0.5);
  EXPECT_FALSE(turned);
}

TEST(HeadingErrorLimit, ExceededMeansThatTheFirstStageIsTurned) {
  Random random(3);
  const HeadingErrorLimit limit = limit_of(Multirotor{});
  for (int n = 0; n < 10000; ++n) {
    const double heading = uniform(random, -pi, pi), to = uniform(random, -pi, pi);
    const Vec2<double> d = direction(heading), d_ref = direction(to);
    const std::vector<double> x = {0, 0, 0, d.x, d.y, 0, 0}, x_ref = {0, 0, 0, d_ref.x, d_ref.y, 0, 0};
    bool turned = false;
    seen(heading, {d_ref}, &turned);
    EXPECT_EQ(limit.exceeded(x.data(), x_ref.data(), 1), turned);
  }
}

TEST(HeadingErrorLimit, AHeadingWithoutAWeightIsLeftAlone) {
  const std::vector<double> none = {1, 1, 1, 0, 0, 1, 1}, one = {0, 0, 0, 0, 1, 0, 0};
  EXPECT_FALSE(HeadingErrorLimit(Multirotor{}, none, {}).applies());
  EXPECT_FALSE(HeadingErrorLimit(Multirotor{}, none, none).applies());
  EXPECT_TRUE(HeadingErrorLimit(Multirotor{}, one, none).applies());
  EXPECT_TRUE(HeadingErrorLimit(Multirotor{}, none, one).applies());
}

TEST(HeadingErrorLimit, RobotsWithoutAHeadingVectorAreLeftAlone) {
  const TextRobot boat{.states = {"b", "p_x", "p_y", "p_z", "a"},
                       .inputs = {"w"},
                       .f = {"w * a", "0", "0", "0", "-w * b"},
                       .position = {"p_x", "p_y", "p_z"},
                       .heading = {"a", "b"}};
  for (const Model& model : {Model(Multirotor{}), Model(Unicycle{}), boat.model()})
    EXPECT_TRUE(limit_of(model).applies());
  for (const Model& model : {Model(AngleMultirotor{}), Model(PointMass{})}) {
    const HeadingErrorLimit limit = limit_of(model);
    EXPECT_FALSE(limit.applies());
    std::vector<double> x(static_cast<std::size_t>(model.nx()), 1.0), x_ref(x.size(), -1.0);
    EXPECT_FALSE(limit.exceeded(x.data(), x_ref.data(), 1));
    EXPECT_FALSE(limit(x.data(), 1, x_ref.data(), 1, model.nx(), 1));
    EXPECT_EQ(x_ref, std::vector<double>(x.size(), -1.0));
  }
  // Where the heading stands is a matter of the robot.
  const std::vector<double> x = {0, 9, 9, 9, 1};
  std::vector<double> x_ref = {0, 9, 9, 9, -1};
  EXPECT_TRUE(limit_of(boat.model())(x.data(), 1, x_ref.data(), 1, 5, 1));
  EXPECT_NEAR(x_ref[4], -0.5, 1e-15);
  EXPECT_NEAR(x_ref[0], std::sqrt(0.75), 1e-15);
}

}  // namespace
}  // namespace sightline
