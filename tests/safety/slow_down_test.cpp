#include "sightline/safety/slow_down.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

// A point is at the robot for a while, then it follows no faster than `speed`. A request lasts
// while it is left behind.
template <RobotModel M>
void expect_gains_little(const M& robot, double delay) {
  const Model model(robot);
  SlowDownOptions o = {.speed = 0.3, .unrequested = 0.9, .climb = 0.2, .delay = delay};
  o.slowing = least_deceleration(view_motion(model, model.u_min(), model.u_max()), 0.0);
  const double most = gain_until_slow(o, 0.0);
  Random random(3);
  double farthest = 0.0, fastest = 0.0;
  for (int flight = 0; flight < 20; ++flight) {
    SlowDown slow_down(model, model.u_min(), model.u_max(), o);
    std::vector<double> x(static_cast<std::size_t>(model.nx())), u(static_cast<std::size_t>(model.nu())),
        wanted(u.size());
    model.at_rest({{0, 0, 1}, {1, 0}}, x.data());
    Vec3<double> point = {0, 0, 1};
    bool behind = false;
    for (int k = 0; k < 1500; ++k) {
      if (k % 300 == 0)
        for (std::size_t i = 0; i < u.size(); ++i)
          wanted[i] = i == u.size() - 1 ? 0.0
                      : random() & 1    ? uniform(random, model.u_min()[i], model.u_max()[i])
                                        : model.u_max()[i];
      u = wanted;
      slow_down.filter(behind, x, u);
      for (std::size_t i = 0; i < u.size(); ++i) {
        EXPECT_GE(u[i], model.u_min()[i] - 1e-9);
        EXPECT_LE(u[i], model.u_max()[i] + 1e-9);
      }
      EXPECT_TRUE(slow_down.keeps(u));
      model.step(x.data(), u.data(), o.period);
      (void)model.normalise(x.data());
      const Sight<double> now = model.sight(x.data(), u.data());
      fastest = std::max(fastest, std::hypot(now.v.x, now.v.y));
      const Vec2<double> way = {now.p.x - point.x, now.p.y - point.y};
      const double distance = std::hypot(way.x, way.y),
                   part = k % 300 < 150 ? 1.0 : std::min(1.0, o.speed * o.period / distance);
      point.x += part * way.x, point.y += part * way.y;
      behind = part < 1;
      farthest = std::max(farthest, (1 - part) * distance);
    }
  }
  EXPECT_LE(farthest, most);
  EXPECT_GT(farthest, 0.5 * most);
  EXPECT_LE(fastest, o.unrequested + 1e-6);
  EXPECT_GT(fastest, 0.9 * o.unrequested);
}

TEST(SlowDown, ARobotGainsNoMoreThanStatedUntilItIsSlow) {
  for (const double delay : {0.0, 0.1, 0.305}) {
    expect_gains_little(Multirotor{}, delay);
    expect_gains_little(HoverMultirotor{}, delay);
    expect_gains_little(OmniRover{}, delay);
    expect_gains_little(Unicycle{}, delay);
    expect_gains_little(VelocityMultirotor{}, delay);
  }
}

// The speed is convex on the line to full braking, so the second one breaks no bound of the first.
TEST(SlowDown, ForTwoObserversTheCommandKeepsTheBoundsOfBoth) {
  const Model model(Multirotor{});
  const double most = least_deceleration(view_motion(model, model.u_min(), model.u_max()), 0.0);
  SlowDown one(model, model.u_min(), model.u_max(),
               {.speed = 0.3, .unrequested = 0.9, .climb = 0.3, .slowing = most}),
      other(model, model.u_min(), model.u_max(),
            {.speed = 0.5, .unrequested = 0.7, .climb = 0.2, .slowing = 0.6 * most});
  Random random(5);
  for (int k = 0; k < 20000; ++k) {
    std::vector<double> x(7), u(4);
    const double psi = uniform(random, -3, 3);
    model.at_rest({{0, 0, 1}, {std::cos(psi), std::sin(psi)}}, x.data());
    x[5] = uniform(random, -0.8, 0.8), x[6] = uniform(random, -0.8, 0.8);
    for (double& value : u) value = uniform(random, -1, 1);
    const bool by_one = random() & 1, by_other = random() & 1;
    one.filter(by_one, x, u);
    other.filter(by_other, x, u);
    EXPECT_TRUE(one.keeps(u) && other.keeps(u)) << k;
  }
}

TEST(SlowDown, ChangesNoCommandWithinTheBounds) {
  const Model model(Multirotor{});
  SlowDown slow_down(model, model.u_min(), model.u_max(), {.speed = 0.5, .unrequested = 0.8});
  std::vector<double> x(7), u = {0.2, -0.1, 0.1, 1.0};
  model.at_rest({{0, 0, 1}, {1, 0}}, x.data());
  const std::vector<double> wanted = u;
  slow_down.filter(true, x, u);
  EXPECT_EQ(u, wanted);
}

}  // namespace
}  // namespace sightline
