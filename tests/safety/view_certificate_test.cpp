#include "sightline/safety/view_certificate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/view_set.hpp"

namespace sightline {
namespace {

using test::cone_limits;
using test::pyramid_limits;
using test::view_limits;
using test::view_task;

ViewSection section_of(const ViewTask& task, const std::vector<Potential>& limits) {
  return ViewSection(view_region(limits, task.motion));
}

double largest_speed(const ViewBounds& bounds, const std::vector<Potential>& limits) {
  const ViewTask task = view_task(Multirotor{}, bounds, limits);
  return certified_speed(task, section_of(task, limits)).speed;
}

TEST(ViewCertificate, CertifiesTheSpeedsOfTheRecipe) {
  EXPECT_GE(largest_speed({}, cone_limits()), 0.96);
  EXPECT_GE(largest_speed({}, cone_limits(0.5, MountFrame::body)), 0.87);
  EXPECT_GE(largest_speed({}, pyramid_limits()), 0.91);
  EXPECT_GE(largest_speed({}, cone_limits(0.3)), 0.87);
  EXPECT_GE(largest_speed({}, cone_limits(0.2)), 0.83);
  EXPECT_GE(largest_speed({.acceleration = 0.3}, cone_limits()), 2.0);
  EXPECT_GE(largest_speed({.wind = 0.1458}, cone_limits()), 0.90);
  EXPECT_GE(largest_speed({.spread = 0.1}, cone_limits()), 0.81);
}

// Between 0.655 and 2 m the robot must flee at W, brake and pursue at W. Its greatest radial
// acceleration, of both thrusts, is 1.36 b. No controller does better.
TEST(ViewCertificate, CertifiesNoMoreThanAnyControllerCanKeep) {
  EXPECT_LE(largest_speed({}, cone_limits()), 1.20);
  EXPECT_EQ(
      certified_speed(view_task(Multirotor{}), section_of(view_task(Multirotor{}), cone_limits())).limit,
      ViewLimit::range);
}

TEST(ViewCertificate, CertifiesLessForEachGreaterBound) {
  const double base = largest_speed({}, cone_limits());
  for (const ViewBounds& harder :
       {ViewBounds{.climb = 0.8}, ViewBounds{.age = 0.1}, ViewBounds{.error = 0.02},
        ViewBounds{.spread = 0.1}, ViewBounds{.wind = 0.2}}) {
    EXPECT_LT(largest_speed(harder, cone_limits()), base);
    EXPECT_GT(largest_speed(harder, cone_limits()), 0.5);
  }
  EXPECT_LT(largest_speed({.acceleration = 0.8}, cone_limits()),
            largest_speed({.acceleration = 0.1}, cone_limits()));
  EXPECT_LT(largest_speed({}, view_limits(SensorCone{}, 1.2)), base);
  EXPECT_LT(largest_speed({}, view_limits(SensorCone{}, 1.0, 1.8)), base);
}

// A right angle exchanges two inputs of equal thrust. Between, the longer diagonal of their square
// serves.
TEST(ViewCertificate, CertifiesNoLessOfASensorThatLooksAside) {
  const double ahead = largest_speed({}, test::aside_limits(0.0));
  for (const double yaw : {1.5708, -1.5708, 3.1416})
    EXPECT_NEAR(largest_speed({}, test::aside_limits(yaw)), ahead, 1e-9) << yaw;
  for (const double yaw : {0.3, 0.8, -2.2})
    EXPECT_GE(largest_speed({}, test::aside_limits(yaw)), ahead) << yaw;
  const auto in_wind = [](double yaw) { return largest_speed({.wind = 0.2}, test::aside_limits(yaw)); };
  EXPECT_NEAR(in_wind(-1.5708), in_wind(0.0), 1e-9);
  EXPECT_GE(in_wind(0.8), 0.9 * in_wind(0.0));
}

TEST(ViewCertificate, PushesOfASensorThatLooksAsideAreThoseOfCommands) {
  Random random(4);
  for (int k = 0; k < 2000; ++k) {
    const double yaw = uniform(random, -4, 4), b = uniform(random, 0.5, 2), b_s = uniform(random, 0.5, 2);
    const Vec2<double> ahead = {std::cos(yaw), std::sin(yaw)};
    const ViewMotion motion = {.along = {.most = b}, .across = {.most = b_s}, .ahead = ahead};
    const Vec2<double> most = motion.pushes(uniform(random, 0.1, 0.9));
    double nearest = infinity;
    for (const double x : {-most.x, most.x})
      for (const double y : {-most.y, most.y}) {
        const Vec2<double> a = rotate(ahead, Vec2<double>{x, y});
        nearest = std::min({nearest, b - std::abs(a.x), b_s - std::abs(a.y)});
      }
    EXPECT_NEAR(nearest, 0.0, 1e-12);
    EXPECT_TRUE(most.x > 0 && most.y > 0);
  }
}

TEST(ViewCertificate, GivesNoSetAboveItsLargestSpeedAndOneBelow) {
  for (const double acceleration : {infinity, 0.5}) {
    ViewTask task = view_task(Multirotor{}, {.acceleration = acceleration});
    const ViewSection section = section_of(task, cone_limits());
    const double speed = certified_speed(task, section).speed;
    for (const double part : {0.2, 0.6, 0.9, 1.0}) {
      task.bounds.speed = part * speed;
      EXPECT_TRUE(certify_view(task, section).exists()) << task.bounds.speed;
    }
    task.bounds.speed = 1.02 * speed;
    EXPECT_FALSE(certify_view(task, section).exists());
  }
}

// The braking distance of a flight that brakes at full thrust, in steps of 0.1 ms.
TEST(ViewCertificate, ItsBrakingDistanceIsThatOfASimulatedFlight) {
  for (const ViewBrake& brake :
       {ViewBrake{0.5092, 1.458 - 0.5092 * 0.7, 0.7}, ViewBrake{0.0, 1.0, 0.3}, ViewBrake{2.5, 0.2, 0.9}}) {
    for (const double start : {-0.2, 0.0, 0.5, 1.5}) {
      if (start <= -brake.speed) continue;
      double v = start, distance = 0.0;
      constexpr double step = 1e-4;
      while (v > -brake.speed) {
        const double next = v - step * (brake.thrust + brake.drag * brake.speed + brake.drag * v);
        distance += step * std::max(0.0, 0.5 * (v + next) + brake.speed), v = next;
      }
      EXPECT_NEAR(brake.distance(start), distance, 2e-3 * distance + 1e-6);
      EXPECT_NEAR(brake.fastest(brake.distance(start)), start, 1e-9);
      EXPECT_NEAR(brake.slope(start), (brake.distance(start + 1e-6) - brake.distance(start - 1e-6)) / 2e-6,
                  1e-6);
    }
    EXPECT_EQ(brake.distance(-brake.speed - 0.1), 0.0);
    EXPECT_EQ(brake.fastest(0.0), -brake.speed);
  }
}

/// Whether the target is where it must be, by the potentials themselves.
/// @param theta  from the heading
bool is_seen(const std::vector<Potential>& limits, double r, double theta, double h,
             const Vec2<double>& lean) {
  const Sight<double> robot = {{{0, 0, h}, {1, 0}}, {}, lean},
                      target = {{{r * std::cos(theta), r * std::sin(theta), 0}, {1, 0}}, {}};
  return std::all_of(limits.begin(), limits.end(),
                     [&](const Potential& limit) { return limit.violation(robot, target) <= 0; });
}

TEST(ViewCertificate, EveryStateOfItsSetHasTheTargetInTheRegion) {
  Random random(3);
  struct Case {
    std::vector<Potential> limits;
    ViewBounds bounds;
  };
  for (const Case& of :
       {Case{cone_limits(), {}}, Case{cone_limits(0.3), {}}, Case{pyramid_limits(), {}},
        Case{cone_limits(0.5, MountFrame::body), {}}, Case{cone_limits(), {.spread = 0.05}},
        Case{test::aside_limits(1.5708), {}}, Case{test::aside_limits(3.1416, MountFrame::body), {}},
        Case{test::aside_limits(-1.0, MountFrame::body), {.spread = 0.05}}}) {
    const ViewTask task = view_task(Multirotor{}, of.bounds, of.limits);
    const ViewCertificate z = certify_view(task, section_of(task, of.limits));
    ASSERT_TRUE(z.exists());
    int missed = 0;
    for (int k = 0; k < 20000; ++k) {
      const double r = test::edgy(random, true, z.near, z.far),
                   theta = test::edgy(random, true, -z.theta, z.theta) + test::yaw_of(z),
                   h = test::edgy(random, true, z.at(z.low, r), z.at(z.high, r)), a = uniform(random, -4, 4),
                   off = of.bounds.spread * std::sqrt(uniform(random, 0, 1));
      const double x = r * std::cos(theta) + off * std::cos(a), y = r * std::sin(theta) + off * std::sin(a);
      missed += !is_seen(
          of.limits, std::hypot(x, y), std::atan2(y, x), h,
          {uniform(random, -1, 1) * task.motion.lean.x, uniform(random, -1, 1) * task.motion.lean.y});
    }
    EXPECT_EQ(missed, 0);
  }
}

// The conditions of the theorem, by its formulas, ten times as fine as the certificate's own grid.
TEST(ViewCertificate, ItsNumbersKeepTheConditionsOfTheTheorem) {
  struct Case {
    ViewBounds bounds{};
    ViewOdometry odometry{};
  };
  for (const auto& [bounds, odometry] :
       {Case{}, Case{{.speed = 0.9}}, Case{{.speed = 0.2, .climb = 0.6}},
        Case{{.speed = 0.2, .climb = 0.6}, {.velocity = 0.2, .turn = 0.4}}}) {
    ViewTask task = view_task(Multirotor{}, bounds);
    task.odometry = odometry;
    const ViewCertificate z = certify_view(task, section_of(task, cone_limits()));
    ASSERT_TRUE(z.exists());
    const test::ViewChecker checker(z);
    const Multirotor robot;
    const double b = robot.b_f, c = -robot.a_f, dt = task.dt, T = z.theta + 1.5 * robot.b_psi * dt;
    const double W_e = (bounds.speed + z.sideward * std::sin(T)) / std::cos(T);
    EXPECT_NEAR(z.brake.speed, W_e, 1e-9);
    EXPECT_NEAR(z.brake.thrust, b - c * W_e, 1e-9);
    const double delta = (b + c * W_e) * dt * std::exp(c * dt),
                 q = 2 * delta * (2 * W_e + delta) / (b + c * W_e);
    EXPECT_GE(z.far - z.near, checker.braking(W_e) + 2 * q);  // (C1)
    constexpr int nodes = 1200;
    const double moved = dt * (W_e + z.brake.fastest(z.far - z.near));
    for (int k = 0; k < nodes; ++k) {
      const double r = z.near + (z.far - z.near) * k / nodes, dr = (z.far - z.near) / nodes;
      const double forward = z.brake.fastest(r + moved - z.near),
                   backward = z.brake.fastest(z.far - r + moved);
      const double sine = std::sin(forward > 0 ? T : z.theta);
      EXPECT_LE(bounds.speed + z.sideward + forward * sine,
                (robot.b_psi - odometry.turn) * r + 1e-9);                     // (C2)
      EXPECT_GE(z.at(z.high, r) - z.at(z.low, r), 4 * robot.b_z * dt - 1e-9);  // (C3)
      const double climb = robot.b_z - bounds.climb - odometry.velocity;
      const double top = (z.at(z.high, r + dr) - z.at(z.high, r)) / dr,
                   low = (z.at(z.low, r + dr) - z.at(z.low, r)) / dr;
      EXPECT_LE(std::max(top, -low) * (W_e + forward), climb + 1e-6);   // (C4), as r falls
      EXPECT_LE(std::max(-top, low) * (W_e + backward), climb + 1e-6);  // as r grows
    }
  }
}

TEST(ViewCertificate, ItsHeightsDoNotJumpOverAThinLayer) {
  const ViewSection section([](double ahead, double left, double above) {
    return ahead > 1.08 && ahead < 18.77 && std::abs(left) < 0.5 * ahead && std::abs(above) < 2.1 &&
           std::abs(above) > 0.07;
  });
  int found = 0, over = 0;
  for (int k = 0; k < ViewSection::distances; ++k) {
    for (int i = 0; i < ViewSection::bearings; ++i) {
      const ViewSection::Heights at = section.heights(k, ViewSection::bearing(i), 0.0);
      if (at.is_empty()) continue;
      ++found, over += at.low < 0 && at.high > 0;
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_EQ(over, 0);
}

// Beyond the speed that it keeps on request some command of its set brakes in each direction.
TEST(ViewCertificate, OfARobotOnRequestBrakesAsRequestedBeyondThatSpeed) {
  for (const double yaw : {0.0, 0.1, 0.4, 0.7854, 1.2}) {
    const std::vector<Potential> limits = test::aside_limits(yaw);
    ViewTask task = view_task(Multirotor{}, {.speed = 0.05, .climb = 0.1}, limits);
    task.requested = 0.8;
    const ViewCertificate z = certify_view(task, section_of(task, limits));
    ASSERT_TRUE(z.exists()) << yaw;
    const double needed = 0.98 * std::min(task.motion.along.most, task.motion.across.most);
    EXPECT_LE(norm(z.brake.speed, z.sideward), task.requested);
    for (int k = 0; k <= 20; ++k) {
      const double across = z.sideward * k / 20, along = std::sqrt(square(task.requested) - square(across));
      EXPECT_GE((z.push.x * along + z.push.y * across) / task.requested, needed) << yaw << " " << across;
    }
  }
}

TEST(ViewCertificate, FindsHowTheCommandsMoveARobot) {
  const ViewMotion flies = view_task(Multirotor{}).motion, rolls = view_task(OmniRover{}).motion,
                   drives = view_task(Unicycle{}).motion;
  EXPECT_NEAR(flies.along.gain, 1.458, 1e-6);
  EXPECT_NEAR(flies.across.gain, -1.458, 1e-6);
  EXPECT_NEAR(flies.along.drag, 0.5092, 1e-4);
  EXPECT_NEAR(flies.climb.most, 1.0, 1e-9);
  EXPECT_NEAR(flies.turn.most, 1.6, 1e-6);
  EXPECT_NEAR(flies.lean.x, 1.458 / gravity, 1e-9);
  EXPECT_EQ(rolls.climb.input, -1);
  EXPECT_EQ(rolls.turn.input, 2);
  EXPECT_EQ(drives.across.input, -1);
  EXPECT_EQ(drives.turn.input, 1);
}

TEST(ViewCertificate, FindsLagsAndTheFrameOfTheVelocity) {
  const ViewMotion px4 = view_task(VelocityMultirotor{}).motion, hover = view_task(HoverMultirotor{}).motion;
  EXPECT_NEAR(px4.climb.lag, 0.35, 1e-4);
  EXPECT_NEAR(px4.turn.lag, 0.2, 1e-4);
  EXPECT_NEAR(px4.climb.most, 1.0, 1e-3);
  EXPECT_NEAR(px4.turn.most, 0.78, 1e-3);
  EXPECT_EQ(px4.rate_state, 8);
  EXPECT_FALSE(px4.is_level);
  EXPECT_TRUE(hover.is_level);
  EXPECT_EQ(hover.turn.lag, 0.0);
  EXPECT_NEAR(hover.along.drag, -HoverMultirotor{}.a_f, 1e-4);
}

TEST(ViewCertificate, RefusesARobotThatMovesOtherwiseByName) {
  const auto refusal = [](const auto& robot) { return refusal_of([&] { (void)view_task(robot); }); };
  EXPECT_EQ(
      refusal(LaggingHoverMultirotor{}),
      "\"hover_multirotor\" does not accelerate along its heading at once, by one input, expected one that "
      "does");
  EXPECT_EQ(refusal(PointMass{}), "\"point_mass\" does not turn by one input, expected one that turns it");
  EXPECT_EQ(refusal_of([] { (void)view_task(Unicycle{}, {}, test::aside_limits(1.57)); }),
            "\"unicycle\" does not move sideward, expected a sensor that looks ahead or back");
}

TEST(ViewCertificate, RefusesARegionThatIsNotOneOfThePlaceAlone) {
  const auto refusal = [](std::vector<Potential> limits) {
    return refusal_of([&] { ViewSection(view_region(std::move(limits), {})); });
  };
  EXPECT_EQ(refusal({SensorCone{}}),
            "the region reaches beyond 30 m, expected a limit of the distance such as d_max");
  EXPECT_EQ(
      refusal(view_limits(SensorCone{}, 3.0, 2.0)),
      "no place within 30 m in the direction of the sensor is in the region, expected some: the certificate "
      "keeps the target there");
  EXPECT_EQ(refusal(view_limits(Region(all_of({"x > 0 m", "target.v_x < 0.1 m/s"})))),
            "the limit \"region\" depends on more than the relative position, expected one of the "
            "position alone");
}

}  // namespace
}  // namespace sightline
