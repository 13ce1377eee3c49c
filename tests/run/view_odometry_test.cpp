// The frame in which the view of a robot that is localized by vision is kept: whatever its pose
// estimate does.
#include "sightline/run/view_odometry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "sightline/robots.hpp"
#include "sightline/run/team_view.hpp"
#include "sightline/safety/view_filter.hpp"
#include "tests/support/random.hpp"
#include "tests/support/view_set.hpp"

namespace sightline {
namespace {

constexpr double odometry_period = 0.01, odometry_reach = 3.0;

Vec2<double> direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
Vec2<double> turned_into(double psi, const Vec2<double>& v_G) { return rotate(direction(-psi), v_G); }
double heading_of(std::span<const double> x) { return std::atan2(x[4], x[3]); }
/// A body's horizontal position relative to a robot, in the frame of its heading.
Vec2<double> seen_from(std::span<const double> x, const Vec3<double>& p) {
  return turned_into(heading_of(x), {p.x - x[0], p.y - x[1]});
}
Vec2<double> any_within(Random& random, double most) {
  const Vec2<double> d = direction(uniform(random, -4, 4));
  const double length = most * (random() % 2 == 0 ? 1.0 : uniform(random, 0, 1));
  return {length * d.x, length * d.y};
}

/// What the filter of the view uses in one period, of the time at which its command takes effect.
struct Used {
  Vec2<double> place, v;  // of the target, and velocity of the robot, in the frame of its heading
  double above;
};

// The pose estimate jumps as it likes, as long as position relative to the target, velocity and yaw
// rate are within their bounds. The truth is flown beside it, with wind, and with commands that act
// late.
template <RobotModel M>
void fly_beside_truth(const M& robot, std::uint64_t seed) {
  const Model model(robot);
  Random random(seed);
  for (int flight = 0; flight < 12; ++flight) {
    const int late = flight % 3 * 8;
    const ViewBounds bounds = {.speed = uniform(random, 0.0, 0.4),
                               .climb = 0.2,
                               .error = uniform(random, 0.01, 0.08),
                               .wind = flight % 4 == 0 ? 0.0 : uniform(random, 0.1, 0.8)};
    const ViewOdometry errors = {.velocity = uniform(random, 0.03, 0.15),
                                 .turn = uniform(random, 0.0, 0.05),
                                 .delay = late * odometry_period};
    ViewTask task = test::view_task(robot, bounds);
    task.odometry = errors, task.bounds = errors.seen(bounds, odometry_reach, odometry_period);
    const ViewBounds::Known known = task.bounds.known(odometry_period);
    const double c = task.motion.along.drag, E = (1 - std::exp(-c * odometry_period)) / c,
                 F = (odometry_period - E) / c;
    OdometryFrame frame(model, task);
    SlowState own(model, task);
    SlowEstimate estimate(task.bounds, odometry_period);

    std::vector<double> x = test::state_of(model, {.z = 2.0});
    Vec3<double> target = {1.5, 0.0, 1.4};
    std::vector<std::vector<double>> commands(size(late), std::vector<double>(4));  // as they act
    std::vector<Used> used;
    std::vector<double> u(4);
    double gauge = 0.0, turned = 0.0, climbed = 0.0, farthest = 0.0, off = 0.0, off_v = 0.0, off_h = 0.0;
    for (int k = 0; k < 2500; ++k) {
      const auto now = size(k);
      // The estimate: a turn about the target, of any size, is no error.
      if (k % 20 == 0) gauge = uniform(random, -1, 1);
      const double psi = heading_of(x) + gauge;
      const Vec2<double> q = seen_from(x, target), e = any_within(random, bounds.error),
                         e_v = any_within(random, errors.velocity);
      const Vec2<double> from = rotate<double>(direction(psi), {q.x + e.x, q.y + e.y}),
                         v = rotate<double>(direction(psi), {x[5] + e_v.x, x[6] + e_v.y});
      PoseEstimate pose{
          .known = true,
          .stamp = k * odometry_period,
          .p = {target.x - from.x, target.y - from.y, x[2] + uniform(random, -bounds.error, bounds.error)},
          .v = {v.x, v.y, climbed / odometry_period + uniform(random, -errors.velocity, errors.velocity)},
          .psi = psi,
          .yaw_rate = turned / odometry_period +
                      (flight % 2 == 0 ? errors.turn : uniform(random, -errors.turn, errors.turn))};
      // The state that the loop has: another velocity, predicted by the commands under way.
      std::vector<double> here(x.size());
      model.at_rest({pose.p, direction(psi)}, here.data());
      here[5] = x[5] + uniform(random, -0.3, 0.3), here[6] = x[6] + uniform(random, -0.3, 0.3);
      std::vector<double> there = here;
      for (std::size_t i = now; i < now + size(late); ++i)
        model.step(there.data(), commands[i].data(), odometry_period);
      k == 0 ? frame.begin(pose) : frame.follow(pose);
      const std::span<const double> carried = frame.carry(pose, here, there);
      k == 0 ? own.begin(carried) : own.follow(u, carried, true);
      const std::span<const double> slow = own.state();
      const Vec3<double> y = estimate.follow(frame.place(target, {slow[0], slow[1]}));
      used.push_back({seen_from(slow, y), {slow[5], slow[6]}, slow[2] - y.z});

      // The truth of the time of which an earlier period's command takes effect now.
      if (k >= late) {
        const Used& then = used[used.size() - 1 - size(late)];
        off = std::max(off, norm(then.place.x - q.x, then.place.y - q.y));
        off_v = std::max(off_v, norm(then.v.x - x[5], then.v.y - x[6]));
        off_h = std::max(off_h, std::abs(then.above - (x[2] - target.z)));
        farthest = std::max(farthest, norm(q.x, q.y));
      }

      // The next command, towards the target from afar; and the motion of a period, by a late one.
      const double pull = norm(q.x, q.y) > 1.5 ? 0.3 : -0.3;
      u = {std::clamp(pull * q.x + uniform(random, -0.2, 0.2) - 0.5 * x[5], -0.5, 0.5),
           std::clamp(-pull * q.y + uniform(random, -0.2, 0.2) + 0.5 * x[6], -0.5, 0.5),
           k % 46 < 23 ? 1.0 : -1.0, 0.4 * std::sin(0.013 * k)};
      commands.push_back(u);
      const double psi_before = heading_of(x), z_before = x[2];
      model.step(x.data(), commands[now].data(), odometry_period);
      const int blown = k / 80, turns = k / 60;
      const Vec2<double> wind = direction(2.4 * blown), wind_V = turned_into(heading_of(x), wind);
      x[0] += bounds.wind * F * wind.x, x[1] += bounds.wind * F * wind.y;
      x[5] += bounds.wind * E * wind_V.x, x[6] += bounds.wind * E * wind_V.y;
      turned = std::remainder(heading_of(x) - psi_before, 2 * std::numbers::pi), climbed = x[2] - z_before;
      const bool far = norm(q.x, q.y) > 2.0;
      const Vec2<double> away = {x[0] - target.x, x[1] - target.y};
      const Vec2<double> way =
          far ? Vec2<double>{away.x / norm(away.x, away.y), away.y / norm(away.x, away.y)}
              : direction(1.9 * turns);
      target = {target.x + bounds.speed * odometry_period * way.x,
                target.y + bounds.speed * odometry_period * way.y,
                target.z + bounds.climb * odometry_period * (x[2] - target.z > 0.6 ? 1.0 : -1.0)};
    }
    constexpr double rounding = 2e-3;  // wind that turns within a period, drag of the delay
    ASSERT_LT(farthest, odometry_reach);
    EXPECT_LE(off, known.radius + rounding) << flight;
    EXPECT_GT(off, 0.3 * bounds.error) << flight;
    EXPECT_LE(off_v, errors.velocity_error(bounds, odometry_period) + rounding) << flight;
    EXPECT_LE(off_h, known.height + errors.delay * task.bounds.climb + rounding) << flight;
  }
}

TEST(ViewOdometry, KeepsPlaceAndVelocityWhateverThePoseEstimateDoes) {
  fly_beside_truth(Multirotor{}, 3);
  fly_beside_truth(LaggedHoverMultirotor<HoverLags::none>{.tau = 0.0, .tau_z = 0.0, .tau_psi = 0.0}, 4);
}

TEST(ViewOdometry, ItsBoundsGrowWithEachError) {
  const ViewBounds bounds = {.speed = 0.3, .climb = 0.1, .error = 0.04, .wind = 0.5};
  const ViewOdometry least = {.velocity = 0.05, .turn = 0.02, .delay = 0.1};
  const ViewBounds seen = least.seen(bounds, odometry_reach, odometry_period);
  EXPECT_EQ(ViewOdometry{}.seen(bounds, odometry_reach, odometry_period).speed, bounds.speed);
  EXPECT_GT(seen.speed, bounds.speed + least.velocity + least.turn * odometry_reach);
  for (const ViewOdometry& more : {ViewOdometry{0.1, 0.02, 0.1}, {0.05, 0.04, 0.1}, {0.05, 0.02, 0.2}}) {
    const ViewBounds other = more.seen(bounds, odometry_reach, odometry_period);
    EXPECT_GT(other.speed, seen.speed);
    EXPECT_GT(other.error, seen.error);
  }
}

/// A view of uav1 by uav0, which is localized by vision, both at rest, from given estimates of its
/// heading.
class GivenView {
 public:
  GivenView() {
    const Multirotor robot;
    for (const char* name : {"uav0", "uav1"}) team_.add(robot, {.name = name});
    CertifiedView view{.observer = BodyId{0}, .target = BodyId{1}};
    view.bounds = {.speed = 0.1, .climb = 0.1, .error = 0.03};
    ViewTask task = test::view_task(robot, view.bounds);
    task.odometry = {.velocity = 0.05, .turn = 0.02};
    const ViewSection section(view_region(test::cone_limits(), task.motion));
    task.bounds = task.odometry.seen(view.bounds, section.reach(), odometry_period);
    const ViewCertificate z = certify_view(task, section);
    view.filter = std::make_shared<const ViewFilter>(Model(robot), z);
    const double r = 0.5 * (z.near + z.far);
    from_ = {-r, 0.0, 1.0 + 0.5 * (z.at(z.low, r) + z.at(z.high, r))};
    options_.period = odometry_period, options_.views.push_back(view);
    view_.emplace(team_, options_);
  }
  ViewRecord after(double psi, double age = 0.0, double sigma = 0.0) {
    const Vec2<double> d = direction(psi);
    const std::vector<double> x = {from_.x, from_.y, from_.z, d.x, d.y, 0, 0, 0, 0, 1.0, 1.0, 0, 0, 0};
    poses_[0] = {.known = true, .stamp = t_ - age, .p = from_, .psi = psi};
    for (int i = 0; i < 3; ++i) poses_[0].P(i, i) = square(sigma);
    std::vector<double> u(8);
    const std::array<double, 2> ages = {age, 0.0}, sigmas = {sigma, 0.0};
    const std::array<Presence, 2> presence = {Presence::steered, Presence::steered};
    const std::array<FallbackLevel, 2> levels{};
    const std::vector<double> added(8);
    view_->accept_poses(poses_);
    view_->keep_views(t_, {x, x, {}, ages, sigmas, presence, levels, added, nullptr}, u);
    view_->judge(u);
    t_ += odometry_period;
    return view_->records()[0];
  }

 private:
  Team team_;
  GuardOptions options_;
  Vec3<double> from_{};
  std::array<PoseEstimate, 2> poses_{};
  double t_ = 0.0;
  std::optional<TeamView> view_;
};

// It has turned by much in the period without an estimate, after which its yaw rate is 0.
TEST(ViewOdometry, BeginsAnewAfterEachPeriodWithoutASureEstimate) {
  constexpr double turned = 0.016, late = 0.02, unsure = 0.1;
  const ViewRecord anew = GivenView().after(turned);
  ASSERT_TRUE(anew.certified);
  for (const auto& [age, sigma, least] :
       {std::tuple(late, 0.0, ViewReserve::age), std::tuple(0.0, unsure, ViewReserve::error),
        std::tuple(late, unsure, ViewReserve::error)}) {
    GivenView view;
    for (int k = 0; k < 5; ++k) EXPECT_TRUE(view.after(0.0).certified);
    const ViewRecord without = view.after(0.0, age, sigma);
    EXPECT_FALSE(without.certified);
    EXPECT_EQ(without.least, least);
    const ViewRecord then = view.after(turned);
    EXPECT_TRUE(then.certified);
    EXPECT_EQ(then.reserve, anew.reserve);
  }
}

// The deviation of drawn poses; a turn of the whole estimate about the body is none.
TEST(ViewOdometry, RelativeDeviationIsThatOfDrawnPoses) {
  Random random(8);
  for (int k = 0; k < 10; ++k) {
    const Vec3<double> p = {uniform(random, -2, 2), uniform(random, -2, 2), 1.0}, body = {0.5, -0.3, 0.6};
    const double psi = uniform(random, -3, 3);
    std::array<std::array<double, 4>, 5> L{};  // independent causes of errors of (p, psi)
    for (auto& cause : L)
      for (double& value : cause) value = uniform(random, -0.01, 0.01);
    PoseEstimate pose{.known = true, .p = p, .psi = psi};
    for (const auto& cause : L)
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) pose.P(i, j) += cause[size(i)] * cause[size(j)];
    const Vec2<double> q = turned_into(psi, {body.x - p.x, body.y - p.y});
    double sum = 0.0;
    for (const auto& cause : L) {  // linear: the variances of the causes add up
      constexpr double small = 1e-3;
      const Vec2<double> off = turned_into(
          psi + small * cause[3], {body.x - p.x - small * cause[0], body.y - p.y - small * cause[1]});
      sum += (square(off.x - q.x) + square(off.y - q.y)) / square(small) + square(cause[2]);
    }
    EXPECT_NEAR(relative_sigma(pose, body), std::sqrt(sum), 1e-4 * std::sqrt(sum));

    pose.P = {};
    const std::array<double, 4> about = {-(p.y - body.y), p.x - body.x, 0.0, 1.0};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) pose.P(i, j) = about[size(i)] * about[size(j)];
    EXPECT_NEAR(relative_sigma(pose, body), 0.0, 1e-6);
  }
}

}  // namespace
}  // namespace sightline
