#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sightline/model.hpp"
#include "sightline/potential.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

double angle(const Pose<double>& pose) { return std::atan2(pose.d.y, pose.d.x); }

TEST(Constant, IsOnePlaceAtAllTimesWithItsHeadingOrNone) {
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const Constant here{random_point(random, 3)}, facing{here.p, uniform(random, -pi, pi)};
    const double t = uniform(random, -100, 100);
    EXPECT_EQ(norm(here(t).p - here.p), 0.0);
    EXPECT_EQ(here(t).d.x, 0.0);
    EXPECT_EQ(here(t).d.y, 0.0);
    EXPECT_LE(std::fabs(angle(facing(t)) - *facing.heading), 1e-15);
  }
}

TEST(Circle, KeepsItsDistanceAndItsRateAndAsksForNoHeading) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const Circle circle{random_point(random, 3), uniform(random, 0, 2), uniform(random, -1, 1)};
    const double t = uniform(random, -100, 100), h = 1e-5;
    const Pose<double> pose = circle(t);
    EXPECT_LE(relative_error(norm(pose.p - circle.centre), circle.radius), 1e-14);
    EXPECT_EQ(pose.p.z, circle.centre.z);
    EXPECT_EQ(pose.d.x, 0.0);
    EXPECT_EQ(pose.d.y, 0.0);
    const double speed = norm(circle(t + h).p - circle(t - h).p) / (2 * h);
    EXPECT_NEAR(speed, circle.radius * std::fabs(circle.rate), 1e-8);
  }
  const Vec3<double> start = Circle{{1, 2, 3}, 0.5, 0.3}(0.0).p;  // (70)
  EXPECT_EQ(norm(start - Vec3<double>{1.5, 2, 3}), 0.0);
}

/// Rising times and poses at random.
struct Course {
  explicit Course(Random& random) {
    double t = uniform(random, -5, 5);
    for (std::uint64_t n = 1 + random() % 6; n > 0; --n) {
      times.push_back(t += uniform(random, 0.1, 3));
      p.push_back(random_point(random, 3));
      heading.push_back(uniform(random, -7, 7));
    }
  }
  std::vector<double> times;
  std::vector<Vec3<double>> p;
  std::vector<double> heading;
};

template <class R>
void expect_pose(const R& reference, double t, const Course& course, std::size_t i) {
  const Pose<double> pose = reference(t);
  EXPECT_LE(norm(pose.p - course.p[i]), 1e-12);
  EXPECT_NEAR(std::remainder(angle(pose) - course.heading[i], 2 * pi), 0.0, 1e-12);
}

TEST(Waypoints, AreReachedInTimeAndHeldBeforeAndAfter) {
  Random random(2);
  for (int k = 0; k < 500; ++k) {
    const Course course(random);
    const Waypoints way{course.times, course.p, course.heading};
    for (std::size_t i = 0; i < course.times.size(); ++i) expect_pose(way, course.times[i], course, i);
    expect_pose(way, course.times.front() - uniform(random, 0, 100), course, 0);
    expect_pose(way, course.times.back() + uniform(random, 0, 100), course, course.times.size() - 1);
  }
}

TEST(Waypoints, BetweenTwoTheLineIsStraightAndTheTurnTheShorterOne) {
  Random random(3);
  for (int k = 0; k < 2000; ++k) {
    const Course course(random);
    const Waypoints way{course.times, course.p, course.heading};
    for (std::size_t i = 0; i + 1 < course.times.size(); ++i) {
      const double s = uniform(random, 0, 1);
      const Pose<double> pose = way(course.times[i] + s * (course.times[i + 1] - course.times[i]));
      const Vec3<double> expected = (1 - s) * course.p[i] + s * course.p[i + 1];
      EXPECT_LE(norm(pose.p - expected), 1e-13);
      EXPECT_NEAR(dot(pose.d, pose.d), 1.0, 1e-15);
      const double turn = std::remainder(course.heading[i + 1] - course.heading[i], 2 * pi);
      EXPECT_LE(std::fabs(turn), pi);
      EXPECT_NEAR(std::remainder(angle(pose) - course.heading[i] - s * turn, 2 * pi), 0.0, 1e-12);
    }
  }
}

TEST(Steps, ChangeAtTheirTimesAndHoldUntilTheNext) {
  Random random(4);
  for (int k = 0; k < 500; ++k) {
    const Course course(random);
    const Steps steps{course.times, course.p, course.heading};
    expect_pose(steps, course.times.front() - uniform(random, 0, 100), course, 0);
    for (std::size_t i = 0; i < course.times.size(); ++i) {
      expect_pose(steps, course.times[i], course, i);
      if (i > 0) {
        expect_pose(steps, std::nextafter(course.times[i], -1e9), course, i - 1);
      }
    }
    expect_pose(steps, course.times.back() + 1e6, course, course.times.size() - 1);
  }
}

TEST(Reference, WithoutHeadingsNoneIsAskedFor) {
  const Waypoints way{{0, 1}, {{}, {1, 1, 1}}};
  const Steps steps{{0, 1}, {{}, {1, 1, 1}}};
  for (const double t : {-1.0, 0.0, 0.5, 1.0, 2.0}) {
    EXPECT_EQ(dot(way(t).d, way(t).d), 0.0);
    EXPECT_EQ(dot(steps(t).d, steps(t).d), 0.0);
  }
}

TEST(Reference, APoseIsTheRobotAtRestInIt) {
  Random random(5);
  const Circle circle;
  const Reference reference = circle;
  for (const Model& model : {Model(Multirotor{}), Model(AngleMultirotor{}), Model(Body{})}) {
    for (int k = 0; k < 100; ++k) {
      const double t = uniform(random, 0, 100);
      std::vector<double> x(static_cast<std::size_t>(model.nx())), expected(x);
      reference(t, model, x);
      model.at_rest(circle(t), expected.data());
      EXPECT_EQ(x, expected);
    }
  }
}

TEST(Reference, AStateStandsForItself) {
  const Model model = Multirotor{};
  const std::array<double, 7> state = {1, 2, 3, 4, 5, 6, 7};
  const Reference constant = state, listed = std::vector<double>(state.begin(), state.end());
  const Reference moving = [&](double t) {
    auto x = state;
    for (double& v : x) v *= t;
    return x;
  };
  for (const double t : {0.0, 1.0, 2.5}) {
    std::array<double, 7> x{};
    constant(t, model, x);
    EXPECT_EQ(x, state);
    listed(t, model, x);
    EXPECT_EQ(x, state);
    moving(t, model, x);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(x[i], t * state[i]);
  }
}

TEST(Reference, OfNothingIsTheOriginWithoutAHeading) {
  std::array<double, 7> x;
  x.fill(9.0);
  Reference()(3.0, Multirotor{}, x);
  EXPECT_EQ(x, (std::array<double, 7>{}));
}

TEST(Reference, ListsThatDoNotMatchOrTimesThatFallAreRefused) {
  const Vec3<double> p{};
  const auto refused = [](const auto& timed) { EXPECT_THROW(Reference{timed}, std::invalid_argument); };
  refused(Waypoints{.times = {}, .p = {}});
  refused(Waypoints{.times = {0.0, 1.0}, .p = {p}});
  refused(Waypoints{.times = {0.0, 1.0}, .p = {p, p}, .heading = {0.0}});
  refused(Waypoints{.times = {1.0, 0.0}, .p = {p, p}});
  refused(Steps{.times = {0.0, 0.0}, .p = {p, p}});
  refused(Steps{.times = {not_a_number}, .p = {p}});
  EXPECT_NO_THROW(Reference(Steps{.times = {0.0, 1.0}, .p = {p, p}, .heading = {0.0, 1.0}}));
}

TEST(Reference, WhatIsNoPathIsRefusedWithTheFieldAndItsValue) {
  const double bad = not_a_number;
  const auto refusal = [](auto&& make) { return refusal_of([&] { (void)Reference(make()); }); };
  EXPECT_EQ(refusal([] { return Circle{.radius = -1}; }), "circle.radius = -1, expected >= 0 m");
  EXPECT_EQ(refusal([] { return Circle{.radius = 0}; }), "");
  EXPECT_EQ(refusal([&] { return Circle{.rate = bad}; }), "circle.rate = nan, expected finite rad/s");
  EXPECT_EQ(refusal([&] { return Circle{.centre = {0, bad, 0}}; }), "circle.centre = nan, expected finite m");
  EXPECT_EQ(refusal([&] {
              return Waypoints{.times = {0, 1}, .p = {{0, 0, 1}, {0, 0, bad}}};
            }),
            "waypoints.p = nan, expected finite m");
  EXPECT_EQ(refusal([&] {
              return Steps{.times = {0}, .p = {{0, 0, 1}}, .heading = {bad}};
            }),
            "steps.heading = nan, expected finite rad");
  EXPECT_NE(refusal([] { return std::vector<double>{}; }), "");
  EXPECT_NE(refusal([] { return [](double) { return std::vector<double>{}; }; }), "");
}

TEST(Reference, OfAnotherLengthOrThrowingItIsNotANumberAndNothingBesideIsTouched) {
  const Model robot{Multirotor{}};
  const auto throws = [](double) -> Pose<double> { throw std::runtime_error("no"); };
  const auto shrinks = [](double t) { return std::vector<double>(t > 0 ? 3 : 7, 1.0); };
  for (const Reference& reference :
       {Reference(throws), Reference(shrinks), Reference(std::vector<double>(6, 1.0)),
        Reference::between(Reference(shrinks), Reference{}, {.duration = 1.0})}) {
    std::vector<double> x(9, 5.0);
    reference(1.0, robot, std::span(x).first(7));
    for (std::size_t i = 0; i < 7; ++i) EXPECT_TRUE(std::isnan(x[i]));
    EXPECT_EQ(x[7], 5.0);
    std::vector<double> rows(3 * 8, 5.0);
    reference.along(1.0, 0.1, 3, robot, rows.data(), 8, 1);
    for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(std::isnan(rows[i]), i % 8 != 7) << i;
  }
  std::vector<double> too_short(6, 5.0);
  Reference{}(1.0, robot, too_short);
  for (const double v : too_short) EXPECT_TRUE(std::isnan(v));
}

}  // namespace
}  // namespace sightline
