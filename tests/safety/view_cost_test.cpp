#include "sightline/safety/view_cost.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/random.hpp"
#include "tests/support/view_set.hpp"

namespace sightline {
namespace {

ViewCertificate certified_at(const ViewBounds& bounds) {
  const ViewTask task = test::view_task(Multirotor{}, bounds);
  return certify_view(task, ViewSection(view_region(test::cone_limits(), task.motion)));
}

/// Both bodies, with the target at `left` of the heading, `above` below the robot.
struct Placed {
  Sight<double> robot, target;
};
Placed placed(double r, double theta, double above, const Vec2<double>& v, const Vec2<double>& w = {}) {
  constexpr double psi = 0.7;
  const Vec2<double> d = {std::cos(psi), std::sin(psi)}, v_G = rotate(d, v);
  return {
      {{{1, 2, 4}, d}, {v_G.x, v_G.y, 0}},
      {{{1 + r * std::cos(psi + theta), 2 + r * std::sin(psi + theta), 4 - above}, {1, 0}}, {w.x, w.y, 0}}};
}

TEST(ViewCost, ItsLimitIsTheSetOfTheCertificate) {
  Random random(3);
  for (const ViewBounds& bounds : {ViewBounds{.speed = 0.5}, ViewBounds{.speed = 1.2, .acceleration = 0.3}}) {
    const ViewCertificate z = certified_at(bounds);
    const ViewCost cost(z);
    const test::ViewChecker checker(z);
    int inside = 0;
    for (int k = 0; k < 5000; ++k) {
      const double r = uniform(random, 0.5 * z.near, 1.2 * z.far);
      const Vec2<double> w = {uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3)};
      const Placed s = placed(r, 1.5 * uniform(random, -z.theta, z.theta),
                              uniform(random, z.at(z.low, r) - 0.1, z.at(z.high, r) + 0.1),
                              {uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5) * z.sideward}, w);
      const double least = checker.least(s.robot, s.target.p, w), beyond = cost.violation(s.robot, s.target);
      if (std::abs(least) > 1e-3 && std::abs(beyond) > 1e-3) {
        // The checker counts the sideward speed, the limit of the cost does not.
        EXPECT_TRUE(beyond <= 0 || least < 0) << k;
        EXPECT_TRUE(beyond > 0 || least > 0 || bounds.is_velocity_measured()) << k;
      }
      inside += beyond <= 0;
    }
    EXPECT_GT(inside, 200);
  }
}

// The cost is small amid the set, and at least 1 at its boundary for a robot at rest.
TEST(ViewCost, RisesFromTheMiddleOfTheSetToItsBoundary) {
  Random random(4);
  for (const double speed : {0.1, 0.3, 0.5, 0.8}) {
    const ViewCertificate z = certified_at({.speed = speed});
    const ViewCost cost(z);
    const double middle = 0.5 * (z.near + z.far), h = 0.5 * (z.at(z.low, middle) + z.at(z.high, middle)),
                 rest = z.brake.distance(0.0);
    const Placed amid = placed(middle, 0, h, {});
    const double least = cost(amid.robot, amid.target);
    EXPECT_TRUE(speed >= 0.5 || least < 0.5) << speed;
    for (int k = 0; k < 2000; ++k) {
      const double r = uniform(random, z.near + rest + z.step(), z.far - rest - z.step());
      const Placed s = placed(r, 1.5 * uniform(random, -z.theta, z.theta),
                              uniform(random, z.at(z.low, r) - 0.2, z.at(z.high, r) + 0.2), {});
      EXPECT_TRUE(cost.violation(s.robot, s.target) <= 0 || cost(s.robot, s.target) >= 1.0) << k;
    }
  }
}

}  // namespace
}  // namespace sightline
