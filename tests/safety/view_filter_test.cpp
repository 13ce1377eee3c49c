#include "sightline/safety/view_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "cli/allocations.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/view_set.hpp"

namespace sightline {
namespace {

using test::cone_limits;
using test::view_limits;
using test::view_task;
using test::ViewState;

ViewCertificate certificate_of(const ViewTask& task, const std::vector<Potential>& limits) {
  return certify_view(task, ViewSection(view_region(limits, task.motion)));
}
ViewCertificate paper_certificate(const ViewBounds& bounds = {}) {
  return certificate_of(view_task(Multirotor{}, bounds), cone_limits());
}

constexpr std::array<double, 4> least_input = {-1, -1, -1, -1}, most_input = {1, 1, 1, 1};

template <RobotModel M>
void expect_invariant(const M& robot, const ViewBounds& bounds, const std::vector<Potential>& limits) {
  const ViewCertificate z = certificate_of(view_task(robot, bounds, limits), limits);
  ASSERT_TRUE(z.exists());
  const test::ViewStep all = test::one_step(robot, z, 10'000, 5);
  EXPECT_EQ(all.outside, 0) << all.least;
  EXPECT_EQ(all.uncertified, 0);
  EXPECT_GE(all.least, -2e-6);
}

TEST(ViewFilter, NoMoveOfTheTargetLeavesTheSetInOnePeriod) {
  expect_invariant(Multirotor{}, {}, cone_limits());
  expect_invariant(Multirotor{}, {.speed = 0.0, .climb = 0.0}, cone_limits());
  expect_invariant(Multirotor{}, {.speed = 0.97}, cone_limits());
  expect_invariant(Multirotor{}, {.speed = 0.9, .wind = 0.1}, cone_limits());
  expect_invariant(Multirotor{}, {.speed = 0.5, .age = 0.1, .wind = 0.3}, cone_limits());
  expect_invariant(Multirotor{}, {.speed = 0.5}, test::pyramid_limits());
  expect_invariant(Multirotor{}, {.speed = 0.5}, cone_limits(0.5, MountFrame::body));
}

// Its heading and height follow estimated rates, whose errors add to the moves of the target.
TEST(ViewFilter, NorDoErrorsOfTheOdometry) {
  ViewTask task = view_task(Multirotor{}, {.speed = 0.5});
  task.odometry = {.velocity = 0.1, .turn = 0.05};
  const test::ViewStep all = test::one_step(Multirotor{}, certificate_of(task, cone_limits()), 10'000, 5);
  EXPECT_EQ(all.outside, 0) << all.least;
  EXPECT_EQ(all.uncertified, 0);
}

TEST(ViewFilter, OfASensorThatSitsAskewNoneLeavesItEitherAndInItTheTargetIsInView) {
  for (const MountFrame frame : {MountFrame::level, MountFrame::body}) {
    const std::vector<Potential> limits = test::askew_limits(frame);
    expect_invariant(Multirotor{}, {.speed = 0.3}, limits);
    const ViewCertificate z = certificate_of(view_task(Multirotor{}, {.speed = 0.3}, limits), limits);
    const Vec2<double> lean = z.task.motion.lean;
    Random random(8);
    for (int k = 0; k < 5000; ++k) {
      const ViewState s = test::state_in(z, random, k % 4 != 0);
      const Sight<double> robot = {{{0, 0, s.z}, {std::cos(s.psi), std::sin(s.psi)}},
                                   {},
                                   {uniform(random, -lean.x, lean.x), uniform(random, -lean.y, lean.y)}};
      for (const Potential& limit : limits) EXPECT_LE(limit.violation(robot, {{s.target, {1, 0}}, {}}), 1e-9);
    }
  }
}

TEST(ViewFilter, NorOfASensorThatLooksAsideOrBack) {
  using test::aside_limits;
  constexpr double left = 1.5708, right = -1.5708, back = 3.1416;
  expect_invariant(Multirotor{}, {.speed = 0.9}, aside_limits(left));
  expect_invariant(Multirotor{}, {.speed = 0.5, .wind = 0.2}, aside_limits(right, MountFrame::body));
  expect_invariant(Multirotor{}, {.speed = 0.9}, aside_limits(0.7));
  expect_invariant(Multirotor{}, {.speed = 0.5, .wind = 0.2}, aside_limits(-2.0, MountFrame::body));
  expect_invariant(Multirotor{}, {.speed = 1.2, .acceleration = 0.3}, aside_limits(-2.0));
  expect_invariant(HoverMultirotor{}, {.wind = 0.1}, aside_limits(0.7));
  expect_invariant(HoverMultirotor{}, {.speed = 2.0, .acceleration = 0.3}, aside_limits(back));
  expect_invariant(VelocityMultirotor{}, {}, aside_limits(2.0));
  const std::vector<Potential> level = view_limits(SensorCone{.mount = {.pitch = 0.0, .yaw = back}});
  expect_invariant(Unicycle{}, {.climb = 0.0}, level);
}

// Such a robot's drag also moves it along by its speed across.
TEST(ViewFilter, NorOfOneWithOtherThrustAndDragSidewardThanAhead) {
  Multirotor uneven;
  uneven.b_s *= 0.8, uneven.a_s *= 1.5;
  expect_invariant(uneven, {.wind = 0.1}, test::aside_limits(0.7));
  expect_invariant(uneven, {.speed = 0.5, .acceleration = 0.3}, test::aside_limits(-2.0));
  expect_invariant(uneven, {.speed = 0.5}, test::aside_limits(1.5708));
}

// Commands within both intervals stay as they are, though two inputs together make each
// acceleration.
TEST(ViewFilter, ChangesNoCommandOfASensorThatLooksAsideWithoutNeed) {
  const std::vector<Potential> limits = test::aside_limits(0.7);
  const ViewCertificate z = certificate_of(view_task(Multirotor{}, {}, limits), limits);
  const ViewFilter filter(Multirotor{}, z);
  const double r = 0.5 * (z.near + z.far), yaw = test::yaw_of(z);
  const ViewState s = {
      .z = 4, .target = {r * std::cos(yaw), r * std::sin(yaw), 4 - 0.5 * (z.at(z.low, r) + z.at(z.high, r))}};
  const std::vector<double> x = test::state_of(Model(Multirotor{}), s);
  Random random(3);
  for (int k = 0; k < 200; ++k) {
    std::array<double, 4> u = uniform_array<4>(random, -0.1, 0.1);
    const std::array<double, 4> wanted = u;
    EXPECT_FALSE(filter.filter(x, {s.target}, least_input, most_input, u).active);
    EXPECT_EQ(u, wanted);
  }
}

TEST(ViewFilter, NorWhereItsVelocityIsMeasured) {
  expect_invariant(Multirotor{}, {.speed = 1.5, .acceleration = 0.3}, cone_limits());
  expect_invariant(Multirotor{}, {.speed = 1.99, .acceleration = 0.3}, cone_limits());
  expect_invariant(Multirotor{}, {.speed = 0.5, .acceleration = 0.8}, cone_limits());
}

TEST(ViewFilter, NorOfAGroundRobotOrOneThatFollowsVelocities) {
  const std::vector<Potential> level = view_limits(SensorCone{.mount = {.pitch = 0.0}});
  expect_invariant(OmniRover{}, {.climb = 0.0}, level);
  expect_invariant(Unicycle{}, {.climb = 0.0}, level);
  LaggedMultirotor<Lags::plane> follows;
  follows.tau_z = follows.tau_psi = 0.0;
  expect_invariant(follows, {}, cone_limits());
}

TEST(ViewFilter, NorOfARobotWithLagsOrWithAVelocityThatStaysInG) {
  expect_invariant(HoverMultirotor{}, {}, cone_limits());
  expect_invariant(HoverMultirotor{}, {.speed = 3.0, .acceleration = 0.3}, cone_limits());
  expect_invariant(VelocityMultirotor{}, {}, cone_limits());
  expect_invariant(VelocityMultirotor{}, {.speed = 1.0, .acceleration = 0.3}, cone_limits());
  VelocityMultirotor level;
  level.frame = VelocityFrame::level;
  expect_invariant(level, {.speed = 0.9}, cone_limits());
  expect_invariant(VelocityMultirotor::ar_drone(), {.wind = 0.05}, cone_limits());
}

// The same states and commands, with the filter left out.
TEST(ViewFilter, IsNeededAtTheBoundary) {
  const ViewCertificate z = paper_certificate();
  const test::ViewChecker checker(z);
  const Model model(Multirotor{});
  Random random(5);
  int outside = 0;
  for (int k = 0; k < 1000; ++k) {
    const ViewState s = test::state_in(z, random, true);
    std::vector<double> x = test::state_of(Model(Multirotor{}), s);
    const auto u = uniform_array<4>(random, -1, 1);
    model.step(x.data(), u.data(), 0.01);
    double least = infinity;
    for (int move = 0; move < test::moves; ++move) {
      ViewState moved = s;
      test::move(moved, z.task.bounds, move, 0.01);
      least = std::min(least, checker.least(model.sight(x.data(), u.data()), moved.target, moved.w));
    }
    outside += least < 0;
  }
  EXPECT_GT(outside, 300);
}

TEST(ViewFilter, LeavesACommandUnchangedInTheMiddleOfTheSet) {
  const ViewCertificate z = paper_certificate();
  const ViewFilter filter(Multirotor{}, z);
  const double r = 0.5 * (z.near + z.far);
  const ViewState s = {.z = 4, .target = {r, 0, 4 - 0.5 * (z.at(z.low, r) + z.at(z.high, r))}};
  const std::vector<double> x = test::state_of(Model(Multirotor{}), s);
  std::array<double, 4> u = {0.1, -0.05, 0.02, 0.1};
  const std::array<double, 4> wanted = u;
  const ViewFilterResult result = filter.filter(x, {s.target}, least_input, most_input, u);
  EXPECT_EQ(u, wanted);
  EXPECT_FALSE(result.active);
  EXPECT_TRUE(result.certified);
  EXPECT_GT(result.reserve, 0.01);
}

TEST(ViewFilter, ReportsTheReserveThatIsMissedOutsideTheSet) {
  const ViewCertificate z = paper_certificate();
  const ViewFilter filter(Multirotor{}, z);
  const double r = 0.5 * (z.near + z.far), h = 0.5 * (z.at(z.low, r) + z.at(z.high, r));
  const auto least = [&](double distance, double theta, double above) {
    const ViewState s = {.z = 4,
                         .target = {distance * std::cos(theta), distance * std::sin(theta), 4 - above}};
    std::array<double, 4> u = {};
    const ViewFilterResult result =
        filter.filter(test::state_of(Model(Multirotor{}), s), {s.target}, least_input, most_input, u);
    EXPECT_FALSE(result.certified);
    EXPECT_LT(result.reserve, 0);
    return result.least;
  };
  EXPECT_EQ(least(z.near - 0.1, 0, h), ViewReserve::near);
  EXPECT_EQ(least(z.far + 0.1, 0, h), ViewReserve::far);
  EXPECT_EQ(least(r, z.theta + 0.3, h), ViewReserve::left);
  EXPECT_EQ(least(r, -z.theta - 0.3, h), ViewReserve::right);
  EXPECT_EQ(least(r, 0, z.at(z.high, r) + 0.3), ViewReserve::high);
  EXPECT_EQ(least(r, 0, z.at(z.low, r) - 0.3), ViewReserve::low);
}

// From outside, the nearest command returns to the set if the target does not flee.
TEST(ViewFilter, ReturnsToTheSetFromOutside) {
  const ViewCertificate z = paper_certificate();
  const ViewFilter filter(Multirotor{}, z);
  const Model model(Multirotor{});
  Random random(2);
  for (int flight = 0; flight < 50; ++flight) {
    const double r = uniform(random, 0.5, 3.0), theta = uniform(random, -1.2, 1.2);
    const ViewState s = {
        .z = 4, .target = {r * std::cos(theta), r * std::sin(theta), 4 - uniform(random, -0.5, 1.5)}};
    std::vector<double> x = test::state_of(Model(Multirotor{}), s);
    bool certified = false;
    for (int k = 0; k < 1000; ++k) {
      std::array<double, 4> u = {};
      certified = filter.filter(x, {s.target}, least_input, most_input, u).certified;
      model.step(x.data(), u.data(), 0.01);
    }
    EXPECT_TRUE(certified) << flight;
  }
}

TEST(ViewFilter, AlwaysGivesAFiniteCommandWithinTheLimits) {
  const std::vector<Potential> aside = test::aside_limits(0.7);
  const std::array filters = {
      ViewFilter(Multirotor{}, paper_certificate()),
      ViewFilter(Multirotor{}, certificate_of(view_task(Multirotor{}, {}, aside), aside))};
  Random random(4);
  for (int k = 0; k < 20000; ++k) {
    std::vector<double> x(7);
    std::array<double, 4> u;
    for (double& value : x) value = k % 3 == 0 ? random_finite(random) : uniform(random, -3, 3);
    for (double& value : u)
      value = k % 2 == 0 ? random_finite(random) : k % 5 == 1 ? not_a_number : uniform(random, -2, 2);
    Vec3<double> target = random_point(random, k % 4 == 0 ? 1e-9 : 4.0);
    if (k % 7 == 0) target.x = not_a_number;
    if (k % 11 == 0) x[1] = infinite;
    const ViewFilterResult result = filters[random() % 2].filter(x, {target}, least_input, most_input, u);
    for (const double value : u) EXPECT_TRUE(value >= -1 && value <= 1) << k;
    const bool unknown = k % 7 == 0 || k % 11 == 0;
    EXPECT_FALSE(unknown && result.certified) << k;
  }
}

TEST(ViewFilter, AllocatesNothing) {
  if (!cli::counts_allocations()) return;
  const ViewCertificate z = paper_certificate();
  const ViewFilter filter(Multirotor{}, z);
  Random random(6);
  for (int k = 0; k < 200; ++k) {
    const ViewState s = test::state_in(z, random, k % 2 == 0);
    const std::vector<double> x = test::state_of(Model(Multirotor{}), s);
    std::array<double, 4> u = uniform_array<4>(random, -1, 1);
    const std::int64_t before = cli::allocations();
    (void)filter.filter(x, {s.target}, least_input, most_input, u);
    EXPECT_EQ(cli::allocations(), before);
  }
}

// Errors of either sign and any direction, at the bound in every other flight.
TEST(ViewFilter, ItsSlowEstimateStaysWithinTheRadiusOfTheTarget) {
  constexpr double dt = 0.01;
  Random random(9);
  for (int flight = 0; flight < 40; ++flight) {
    const ViewBounds bounds = {
        .speed = uniform(random, 0.0, 1.0), .climb = 0.3, .error = uniform(random, 0.005, 0.05)};
    const ViewBounds::Known known = bounds.known(dt);
    EXPECT_LT(known.radius, 3 * bounds.error + 2 * bounds.speed * dt);
    SlowEstimate estimate(bounds, dt);
    ViewState s;
    double off = 0, above = 0, farthest = 0, steepest = 0, heading = 0;
    Vec3<double> before = estimate.follow(s.target);
    for (int k = 0; k < 3000; ++k) {
      const double a = k % 200 < 100 ? 0.05 * k : uniform(random, -4, 4),
                   error = bounds.error * (flight % 2 == 0 ? 1.0 : uniform(random, 0, 1));
      if (k % 70 == 0) heading = uniform(random, -4, 4);
      test::move(s, bounds, {std::cos(heading), std::sin(heading)}, uniform(random, -1, 1), dt);
      const Vec3<double> e =
          estimate.follow({s.target.x + error * std::cos(a), s.target.y + error * std::sin(a),
                           s.target.z + uniform(random, -error, error)});
      off = std::max(off, std::hypot(e.x - s.target.x, e.y - s.target.y));
      above = std::max(above, std::abs(e.z - s.target.z));
      farthest = std::max(farthest, std::hypot(e.x - before.x, e.y - before.y) / dt);
      steepest = std::max(steepest, std::abs(e.z - before.z) / dt);
      before = e;
    }
    EXPECT_LE(off, known.radius + 1e-9);
    EXPECT_LE(above, known.height + 1e-9);
    EXPECT_LE(farthest, known.speed + 1e-9);
    EXPECT_LE(steepest, known.climb + 1e-9);
  }
}

// The wind pushes the robot, and no prediction from a measurement has the wind of its time.
TEST(ViewFilter, ItsSlowStateStaysBesideRobotAndPrediction) {
  constexpr double dt = 0.01;
  constexpr int oldest = 8;
  const Model model(Multirotor{});
  Random random(12);
  for (int flight = 0; flight < 20; ++flight) {
    const double wind = flight == 0 ? 0.0 : uniform(random, 0.1, 1.0);
    const ViewTask task = view_task(Multirotor{}, {.age = oldest * dt, .wind = wind});
    const ViewPrediction most = view_prediction(task.bounds, dt);
    const double c = task.motion.along.drag, E = (1 - std::exp(-c * dt)) / c, F = (dt - E) / c;
    SlowState slow(model, task);
    std::vector<std::vector<double>> truth = {test::state_of(model, {})}, commands;
    slow.begin(truth[0]);
    int measured = 0;
    double push = 0.0;
    for (int k = 1; k < 1500; ++k) {
      std::vector<double> u(4);
      for (double& value : u) value = uniform(random, -1, 1);
      commands.push_back(u);
      std::vector<double> x = truth.back();
      if (k % 60 == 0) push = uniform(random, -4, 4);
      const Vec2<double> along = rotate<double>({x[3], -x[4]}, {std::cos(push), std::sin(push)});
      model.step(x.data(), u.data(), dt);
      x[0] += wind * F * std::cos(push), x[1] += wind * F * std::sin(push);
      x[5] += wind * E * along.x, x[6] += wind * E * along.y;
      truth.push_back(x);
      // A measurement arrives now and then, younger or older than the last one was.
      if (k - measured == oldest + 1 || random() % 4 == 0)
        measured = std::max(measured, k - static_cast<int>(random() % (oldest + 1)));
      std::vector<double> predicted = truth[static_cast<std::size_t>(measured)];
      for (int i = measured; i < k; ++i)
        model.step(predicted.data(), commands[static_cast<std::size_t>(i)].data(), dt);
      std::vector<double> before(slow.state().begin(), slow.state().end());
      slow.follow(u, predicted, measured < k);
      model.step(before.data(), u.data(), dt);
      const std::span<const double> now = slow.state();
      EXPECT_LE(std::hypot(now[0] - before[0], now[1] - before[1]), most.speed * dt + wind * F + 1e-6);
      EXPECT_LE(slow.lag(), most.lag + 1e-6);
      EXPECT_LE(std::hypot(now[0] - x[0], now[1] - x[1]), most.radius + 1e-6) << flight << " " << k;
    }
  }
}

TEST(ViewFilter, JudgesAForeignCommandAsItsOwn) {
  const ViewCertificate z = paper_certificate();
  const ViewFilter filter(Multirotor{}, z);
  Random random(8);
  int lost = 0;
  for (int k = 0; k < 500; ++k) {
    const ViewState s = test::state_in(z, random, true);
    const std::vector<double> x = test::state_of(Model(Multirotor{}), s);
    const std::array<double, 4> foreign = uniform_array<4>(random, -1, 1);
    std::array<double, 4> u = foreign;
    const ViewFilterResult own = filter.filter(x, {s.target}, least_input, most_input, u);
    EXPECT_TRUE(filter.judge(x, {s.target}, u).certified);
    EXPECT_EQ(filter.judge(x, {s.target}, foreign).reserve, own.reserve);
    lost += !filter.judge(x, {s.target}, foreign).certified;
  }
  EXPECT_GT(lost, 150);
}

TEST(ViewFilter, RefusesWhatItCannotKeep) {
  const ViewCertificate good = paper_certificate();
  ViewCertificate none = good, slow = good;
  none.volume = 0.0, slow.task.dt = 0.2;
  EXPECT_EQ(refusal_of([&] { ViewFilter(Multirotor{}, none); }),
            "no certificate of the view exists, expected one");
  EXPECT_EQ(refusal_of([&] { ViewFilter(Multirotor{}, slow); }),
            "period = 0.2, expected in (0, 0.05] s for a certified view");
}

}  // namespace
}  // namespace sightline
