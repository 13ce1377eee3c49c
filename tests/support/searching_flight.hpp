/// Flights of a robot that is localized by what it sees of another one, behind a guard: hidden
/// targets, wrong estimates, starts from anywhere.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "sightline/loop.hpp"
#include "sightline/potential/tracking.hpp"
#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/tag_world.hpp"

namespace sightline::test {

struct SearchingOptions {
  std::uint64_t seed = 1;
  FilterKind filter = FilterKind::heading;
  double duration = 30.0;
  TagWorld::Hidden hidden{1e9, 1e9};
  double misled_at =
      1e9;  ///< the filter is told a pose that is wrong by 1.1 m and 2 rad, and believes it [s]
  bool starts_anywhere = false;  ///< with any heading, in range
  bool hostile = false;          ///< both robots fly at each other, whatever the solver says
  bool guarded = true;           ///< by the barrier
  SearchOptions search{};
};

struct SearchingOutcome {
  double longest_unseen = 0.0;  ///< truly out of view, after the first 5 s [s]
  double known_from = 1e9;      ///< the first estimate [s]
  double found_after =
      1e9;  ///< after the end of hiding, or after it was misled: a right estimate, in view [s]
  double sigma = 0.0, error = 0.0;                  ///< of the position, at the end of hiding [m]
  double nees = 0.0;                                ///< of position and heading, there
  double nearest = 1e9;                             ///< [m]
  int searches = 0, founds = 0, uncertainties = 0;  ///< events
  FallbackLevel highest = FallbackLevel::valid;     ///< of the observer, once it is localized
};

class SearchingFlight {
 public:
  static constexpr double period = 0.01, half_view = 0.5, reach = 3.0, most_error = 0.3;

  explicit SearchingFlight(const SearchingOptions& options)
      : o(options), draw_(options.seed, StreamId::draw, 3), mount_{.pitch = 0.5, .offset = 0.17} {
    const auto u = [&](double low, double high) { return low + (high - low) * draw_.uniform(); };
    const double ax = u(0.3, 1.5), ay = u(0.3, 1.5), az = u(0, 0.3), wx = u(0.2, 0.6), wy = u(0.2, 0.6),
                 wz = u(0.2, 0.6), px = u(0, 6.28), py = u(0, 6.28), pz = u(0, 6.28), spin = u(-0.2, 0.2),
                 psi = u(0, 6.28);
    const auto path = [=](double t) {
      return std::array<double, 7>{ax * std::cos(wx * t + px),
                                   ay * std::sin(wy * t + py),
                                   1.2 + az * std::sin(wz * t + pz),
                                   std::cos(psi + spin * t),
                                   std::sin(psi + spin * t),
                                   0,
                                   0};
    };
    Team team;
    const AgentId observer = team.add(Multirotor{}, {.R = {.1, .1, .1, .1}, .name = "uav0"});
    const AgentId target = team.add(
        Multirotor{}, {.Q = {1.5, 1.5, 1.6, 1, 1}, .R = {1, 1, 1, 1}, .x_ref = path, .name = "uav1"});
    const Between pair{observer, target};
    const auto feels = felt_by(observer);
    Bearing bearing{.alpha = half_view, .width = 0.1, .tilt = 0.2};
    bearing.mount = mount_;
    team.couple(4.0 * bearing, pair, feels);
    team.couple(4.0 * TooNear{.d_min = 1.0, .kappa = 10}, pair, feels);
    team.couple(8.0 * TooFar{.d_max = 2.0, .kappa = 10}, pair, feels);
    team.couple(0.1 * RelativeVelocity{.v_0 = 1.0}, pair, feels);

    // Beside the target, and above it as the camera looks.
    const std::array<double, 7> p = path(0.0);
    const double side = u(-3.1, 3.1), far = o.starts_anywhere ? u(1.4, 2.5) : 1.7,
                 down = o.starts_anywhere ? u(0.25, 0.65) : 0.45,
                 look = side + std::numbers::pi + (o.starts_anywhere ? u(-3.1, 3.1) : u(-0.2, 0.2));
    std::vector<double> x0 = {p[0] + far * std::cos(down) * std::cos(side),
                              p[1] + far * std::cos(down) * std::sin(side),
                              p[2] + far * std::sin(down),
                              std::cos(look),
                              std::sin(look),
                              0,
                              0};
    x0.insert(x0.end(), p.begin(), p.end());
    PlantOptions plant{.seed = o.seed};
    plant.disturbances.gust_sigma = 0.3;
    world_ = std::make_unique<TelemetryWorld>(
        std::make_unique<TagWorld>(team, x0, std::vector<TagWorld::Camera>{{BodyId{0}, BodyId{1}, mount_}},
                                   plant, o.hidden),
        TelemetryOptions{.seed = o.seed, .robots = {{BodyId{0}}}, .broadcasters = {BodyId{1}}});
    localizer_ = std::make_unique<Localizer>(team, x0,
                                             LocalizerOptions{.robots = {{.robot = BodyId{0},
                                                                          .mount = mount_,
                                                                          .observes = {BodyId{1}},
                                                                          .filter = {.filter = o.filter}}}});
  }

  SearchingOutcome fly() {
    const Team& team = world_->team();
    NewtonRiccati solver(Ocp(team, {.T = 1.0, .N = 20, .dt = period}));
    Guard guard(team, guard_options());
    SearchingOutcome flown;
    std::vector<double> u(8), none(8), plan_ages(2);
    double unseen = 0.0;
    bool misled = false;
    const double event = std::min(o.hidden.until, o.misled_at);
    for (int k = 0; k < std::lround(o.duration / period); ++k) {
      const double t = k * period;
      const Measured now = localizer_->estimate(t, world_->measure(t));
      const PoseEstimate& estimate = localizer_->estimates()[0];
      judge(flown, t, now.truth, estimate, unseen);
      if (!misled && t >= o.misled_at && estimate.known) {
        misled = true;
        localizer_->start(BodyId{0}, estimate.p + Vec3<double>{0.8, 0.75, 0}, wrap(estimate.psi + 2.0),
                          identity<4>(1e-4));
      }
      if (t > event && flown.found_after > 1e8 && estimate.known && localizer_->views()[0].accepted > event &&
          unseen == 0.0 && norm(estimate.p - place(now.truth, 0)) < most_error)
        flown.found_after = t - event;
      const ValidStates& estimated =
          guard.accept_measurement(t, now.measured, now.stamps, localizer_->sigma());
      guard.look(t, localizer_->views());
      std::fill(plan_ages.begin(), plan_ages.end(), guard.knows_all() ? 0.0 : t);
      std::fill(u.begin(), u.end(), 0.0);
      if (guard.knows_all()) {
        const Solution solution = solver.solve(t, estimated);
        std::copy(solution.u.begin(), solution.u.end(), u.begin());
      }
      if (o.hostile) drive(t, now.truth, u);
      guard.fall_back(t, estimated, plan_ages, none, u);
      guard.keep_distances(t, estimated, none, u);
      guard.record(t, u);
      for (const Event& e : guard.events()) {
        flown.searches += e.kind == EventKind::search, flown.founds += e.kind == EventKind::found;
        flown.uncertainties += e.kind == EventKind::measurement_jump;
      }
      if (estimate.known) flown.highest = std::max(flown.highest, guard.levels()[0]);
      localizer_->apply(u, period, 1);
      if (!test::apply(*world_, t, estimated, u, period, 1)) break;
    }
    return flown;
  }

  static constexpr double d_hard = 0.6;

  GuardOptions guard_options() const {
    return {.supervisor = SupervisorOptions{},
            .barrier = o.guarded ? BarrierMode::on : BarrierMode::off,
            .barrier_options = {.floor = 0.3, .ceiling = 10.0},
            .bodies = {{.d_hard = d_hard}, {.d_hard = d_hard}},
            .search = o.search,
            .searchers = {BodyId{0}}};
  }
  World& world() { return *world_; }
  Localizer& localizer() { return *localizer_; }

 private:
  static Vec3<double> place(std::span<const double> x, std::size_t body) {
    return {x[7 * body], x[7 * body + 1], x[7 * body + 2]};
  }

  void judge(SearchingOutcome& flown, double t, std::span<const double> x, const PoseEstimate& estimate,
             double& unseen) const {
    const Vec3<double> own = place(x, 0), other = place(x, 1);
    const Vec3<double> seen = mount_(Pose<double>{own, {x[3], x[4]}}, other);
    unseen = off_axis(seen) > half_view || norm(seen) > reach ? unseen + period : 0.0;
    if (t >= 5.0) flown.longest_unseen = std::max(flown.longest_unseen, unseen);
    if (estimate.known) flown.known_from = std::min(flown.known_from, t);
    flown.nearest = std::min(flown.nearest, norm(own - other));
    if (std::abs(t - o.hidden.until) > 0.5 * period || !estimate.known) return;
    flown.sigma = estimate.position_sigma();
    flown.error = norm(estimate.p - own);
    const Vec3<double> e = estimate.p - own;
    const Column<4> d = {{{{e.x}, {e.y}, {e.z}, {wrap(estimate.psi - std::atan2(x[4], x[3]))}}}};
    flown.nees = (transposed(d) * Cholesky<4>(estimate.P).solve(d))(0, 0);
  }

  /// Both fly at each other, or at random, changing each second.
  void drive(double t, std::span<const double> x, std::span<double> u) {
    if (t >= next_) {
      next_ = t + 1.0;
      at_random_ = draw_.uniform() < 0.3;
      for (double& v : wanted_) v = 2 * draw_.uniform() - 1;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3<double> r = place(x, 1 - i) - place(x, i);
      const double c = x[7 * i + 3], s = x[7 * i + 4], far = std::max(norm(r), 1e-6);
      const std::array<double, 4> at_it = {(c * r.x + s * r.y) / far, -(c * r.y - s * r.x) / far, r.z / far,
                                           0.0};
      for (std::size_t k = 0; k < 4; ++k)
        u[4 * i + k] = std::clamp(at_random_ ? wanted_[4 * i + k] : 2 * at_it[k], -1.0, 1.0);
    }
  }

  SearchingOptions o;
  RandomStream draw_;
  SensorMount mount_;
  std::unique_ptr<TelemetryWorld> world_;
  std::unique_ptr<Localizer> localizer_;
  double next_ = 0.0;
  bool at_random_ = false;
  std::array<double, 8> wanted_{};
};

}  // namespace sightline::test
