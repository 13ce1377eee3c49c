#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/loop.hpp"
#include "sightline/potential/tracking.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/sample_sink.hpp"
#include "tests/support/synthetic_flight.hpp"
#include "tests/support/tag_world.hpp"

namespace sightline {
namespace {

using test::TagWorld;

constexpr double flight_period = 0.01;

/// A body on a slow slow_figure.
std::array<double, 7> slow_figure(double t) {
  return {0.8 * std::cos(0.4 * t), 0.8 * std::sin(0.3 * t), 1.2 + 0.2 * std::sin(0.3 * t), 1, 0, 0, 0};
}

/// Robots in a row behind one that flies the slow_figure, each keeps the one before it in view.
Team followers(int robots) {
  Team team;
  std::vector<AgentId> all;
  for (int i = 0; i < robots; ++i) {
    const std::string name = "uav" + std::to_string(i);
    if (i == 0) {
      all.push_back(team.add(
          Multirotor{}, {.Q = {1.5, 1.5, 1.6, 1, 1}, .R = {1, 1, 1, 1}, .x_ref = slow_figure, .name = name}));
      continue;
    }
    all.push_back(team.add(Multirotor{}, {.R = {.1, .1, .1, .1}, .name = name}));
    const Between pair{all.back(), all[all.size() - 2]};
    const auto feels = felt_by(all.back());
    team.couple(4.0 * Bearing{.alpha = 0.5, .width = 0.1, .tilt = 0.2}, pair, feels);
    team.couple(4.0 * TooNear{.d_min = 1.0, .kappa = 10}, pair, feels);
    team.couple(8.0 * TooFar{.d_max = 2.0, .kappa = 10}, pair, feels);
    team.couple(0.1 * RelativeVelocity{.v_0 = 1.0}, pair, feels);
  }
  return team;
}
std::vector<double> in_a_row(int robots) {
  std::vector<double> x;
  for (int i = 0; i < robots; ++i)
    for (const double v : {0.8 + 1.5 * i, 0.0, 1.2 + 0.5 * i, i == 0 ? 1.0 : -1.0, 0.0, 0.0, 0.0})
      x.push_back(v);
  return x;
}

struct LocalizedFlight {
  std::vector<test::Consistency> robots;  // those that are localized
  double longest_out_of_view = 0.0;       // of any of them
  double known_from = -1.0;               // all of them
  double blind_sigma = 0.0;               // greatest [m]
  std::vector<double> end;                // true states
};

/// A world that tells no more than robots would be told, and what localizes uav1 and those behind
/// it by it.
struct Localization {
  std::unique_ptr<TelemetryWorld> world;
  LocalizerOptions options{};
  std::unique_ptr<Localizer> localizer{};

  const PoseEstimate& estimate(int body) const { return localizer->estimates()[at(body)]; }
  Measured measure(double t) { return localizer->estimate(t, world->measure(t)); }
  bool apply(double t, std::span<const double> x, std::span<const double> u) {
    localizer->apply(u, flight_period, 1);
    return test::apply(*world, t, x, u, flight_period, 1);
  }
};

LocalizedFlight fly_localized(Localization& of, double duration, double from = 5.0) {
  const Team& team = of.world->team();
  NewtonRiccati solver(Ocp(team, {.T = 1.0, .N = 20, .dt = flight_period}));
  LocalizedFlight flown;
  flown.robots.resize(of.options.robots.size());
  std::vector<double> rest(static_cast<std::size_t>(team.nu())), u = rest, out(flown.robots.size());
  for (int k = 0; k < std::lround(duration / flight_period); ++k) {
    const double t = k * flight_period;
    const Measured now = of.measure(t);
    for (std::size_t i = 0; i < flown.robots.size(); ++i) {
      const PoseEstimate& estimate = of.estimate(static_cast<int>(i) + 1);
      const BodyId body{static_cast<int>(i) + 1};
      const auto sight = [&](BodyId seen) {
        return team.model(seen).sight(&now.truth[static_cast<std::size_t>(team.state_offset(seen))],
                                      rest.data());
      };
      const Sight<double> own = sight(body), other = sight(BodyId{body.index - 1});
      out[i] = view_angle(SensorMount{}, static_cast<const Pose<double>&>(own), other.p) > 0.5
                   ? out[i] + flight_period
                   : 0.0;
      if (t < from) continue;
      flown.longest_out_of_view = std::max(flown.longest_out_of_view, out[i]);
      if (!estimate.known) ++flown.robots[i].unknown;
      if (estimate.known) {
        flown.robots[i].add(estimate, {.p = own.p, .psi = std::atan2(own.d.y, own.d.x)});
        flown.blind_sigma = std::max(flown.blind_sigma, estimate.position_sigma());
      }
    }
    if (of.localizer->knows_all() && flown.known_from < 0) flown.known_from = t;
    // Until all are known they hold.
    if (of.localizer->knows_all()) {
      const Solution solution = solver.solve(t, now.measured);
      std::copy(solution.u.begin(), solution.u.end(), u.begin());
    }
    flown.end.assign(now.truth.begin(), now.truth.end());
    EXPECT_TRUE(of.apply(t, now.measured, u));
  }
  return flown;
}

/// uav1 and those behind it have no positions.
Localization localized(const Team& team, std::vector<double> start, FilterKind kind, std::uint64_t seed,
                       TagWorld::Hidden hidden = {1e9, 1e9}) {
  const int robots = team.bodies();
  std::vector<TagWorld::Camera> cameras;
  Localization of;
  TelemetryOptions telemetry{.seed = seed, .broadcasters = {BodyId{0}}};
  for (int i = 1; i < robots; ++i) {
    cameras.push_back({BodyId{i}, BodyId{i - 1}, SensorMount{}});
    of.options.robots.push_back({.robot = BodyId{i},
                                 .observes = {BodyId{i - 1}},
                                 .filter = {.filter = kind, .other_error_time = 0.5}});
    telemetry.robots.push_back({BodyId{i}});
  }
  PlantOptions plant{.seed = seed};
  plant.disturbances.gust_sigma = 0.3;
  of.world = std::make_unique<TelemetryWorld>(
      std::make_unique<TagWorld>(team, std::move(start), cameras, plant, hidden), telemetry);
  of.localizer = std::make_unique<Localizer>(of.world->team(), of.world->start(), of.options);
  return of;
}
Localization localized(int robots, FilterKind kind, std::uint64_t seed,
                       TagWorld::Hidden hidden = {1e9, 1e9}) {
  return localized(followers(robots), in_a_row(robots), kind, seed, hidden);
}

TEST(Localizer, ARobotThatSeesNothingButItsNeighbourFliesByWhatItSees) {
  for (const FilterKind kind : {FilterKind::heading, FilterKind::attitude}) {
    test::Consistency all;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      auto flight = localized(2, kind, seed);
      const LocalizedFlight flown = fly_localized(flight, 20.0);
      EXPECT_LT(flown.longest_out_of_view, 0.5) << seed;
      EXPECT_LT(flown.known_from, 0.5) << seed;
      EXPECT_EQ(flown.robots[0].unknown, 0) << seed;
      all.squares += flown.robots[0].squares, all.nees += flown.robots[0].nees;
      all.samples += flown.robots[0].samples;
    }
    EXPECT_LT(all.rmse(), kind == FilterKind::heading ? 0.025 : 0.012);
    EXPECT_GT(all.anees(), 2.5);
    EXPECT_LT(all.anees(), 5.5);
  }
}

TEST(Localizer, HiddenForTwoSecondsItFliesOnAndFindsTheTargetAgain) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    auto flight = localized(2, FilterKind::heading, seed, {.from = 8.0, .until = 10.0});
    const LocalizedFlight flown = fly_localized(flight, 16.0);
    EXPECT_LT(flown.longest_out_of_view, 0.5) << seed;
    EXPECT_GT(flown.blind_sigma, 0.05) << "it says that it does not know";
    EXPECT_LT(flight.estimate(1).position_sigma(), 0.04);
  }
}

TEST(Localizer, AChainOfRobotsHangsOnOneThatKnowsItsPose) {
  test::Consistency last;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    auto flight = localized(4, FilterKind::heading, seed);
    const LocalizedFlight flown = fly_localized(flight, 20.0);
    EXPECT_LT(flown.longest_out_of_view, 0.5) << seed;
    last.squares += flown.robots[2].squares, last.nees += flown.robots[2].nees;
    last.samples += flown.robots[2].samples;
  }
  EXPECT_LT(last.rmse(), 0.03);
  EXPECT_LT(last.anees(), 6.0);
}

TEST(Localizer, ItTellsHowWellAPositionIsKnownAndWhatWasSeen) {
  auto flight = localized(2, FilterKind::heading, 4, {.from = 1.0, .until = 60.0});
  const std::vector<double> u(8);
  double stamp = 0.0;
  int k = 0;
  for (; k < 3000; ++k) {
    const Measured now = flight.measure(k * flight_period);
    stamp = now.stamps[1];
    ASSERT_EQ(flight.localizer->sigma()[0], 0.0) << "it is measured";
    ASSERT_EQ(std::isinf(flight.localizer->sigma()[1]), !flight.localizer->views()[0].localized);
    (void)flight.apply(k * flight_period, now.measured, u);
  }
  EXPECT_EQ(flight.localizer->sigma()[1], flight.estimate(1).position_sigma());
  EXPECT_GT(flight.estimate(1).position_sigma(), 0.5);
  EXPECT_NEAR(stamp, (k - 1) * flight_period, 1e-9) << "its age is that of its motion";
  const View& view = flight.localizer->views()[0];
  EXPECT_TRUE(view.localized);
  EXPECT_EQ(view.robot, BodyId{1});
  EXPECT_EQ(view.target, BodyId{0});
  EXPECT_EQ(view.position_sigma, flight.estimate(1).position_sigma());
  EXPECT_NEAR(view.accepted, 1.0, 0.1);
  EXPECT_NEAR(view.sighted, 1.0, 0.1);
  EXPECT_GT(view.bearing_sigma, 0.2);
  EXPECT_EQ(flight.localizer->uncertainties()[0].after(1.0), 0.0) << "it needs no view";
}

/// Nothing is seen from 3 s on. What the robot says then of a second later is what it says then,
/// and at most the double.
TEST(Localizer, ADoubtAheadIsThatOfARobotThatSeesNothingUntilThen) {
  for (const FilterKind kind : {FilterKind::heading, FilterKind::attitude}) {
    auto flight = localized(2, kind, 5, {.from = 3.0, .until = 60.0});
    const std::vector<double> u(8);
    std::vector<ViewUncertainty> received;
    for (int k = 0; k < 700; ++k) {
      const Measured now = flight.measure(k * flight_period);
      received.push_back(flight.localizer->uncertainties()[1]);
      (void)flight.apply(k * flight_period, now.measured, u);
    }
    EXPECT_LT(received[250].sigma, 0.03) << "it sees";
    for (const int k : {320, 400, 500}) {
      EXPECT_GT(received[size(k)].after(1.0), 0.95 * received[size(k + 100)].sigma) << k;
      EXPECT_LT(received[size(k)].after(1.0), 2.0 * received[size(k + 100)].sigma) << k;
    }
  }
}

TEST(Localizer, ToldWhereItIsItGoesOnFromThere) {
  auto flight = localized(2, FilterKind::heading, 4, {.from = 0.0, .until = 60.0});
  (void)flight.measure(0.0);
  (void)flight.apply(0.0, flight.world->start(), std::vector<double>(8));
  (void)flight.measure(flight_period);
  flight.localizer->start(BodyId{1}, {1, 2, 3}, 0.5, identity<4>(1e-4));
  (void)flight.apply(flight_period, flight.world->start(), std::vector<double>(8));
  (void)flight.measure(2 * flight_period);
  EXPECT_TRUE(flight.estimate(1).known);
  EXPECT_NEAR(norm(flight.estimate(1).p - Vec3<double>{1, 2, 3}), 0.0, 0.02);
  flight.localizer->start(BodyId{0}, {1, 2, 3}, 0.5, identity<4>(1e-4));  // it knows that
}

/// No sensor measures these states, but a barrier that counts the lags of the robot needs them.
TEST(Localizer, TheTiltThatFollowsLateIsThatOfTheModelAndTheYawRateThatOfTheEstimate) {
  Team team = followers(1);
  (void)team.add(LaggedHoverMultirotor<HoverLags::all>{}, {.R = {1, 1, 1, 1}, .name = "late"});
  std::vector<double> start = in_a_row(1);
  for (const double v : {2.3, 0.0, 1.7, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}) start.push_back(v);
  auto flight = localized(team, start, FilterKind::heading, 8);
  const auto late = size(team.state_offset(BodyId{1}));
  constexpr std::size_t a_f = 7, a_s = 8, r = 10;
  double greatest = 0.0;
  for (int k = 0; k < 300; ++k) {
    const double t = k * flight_period, push = k < 100 ? 0.0 : 0.2 * std::sin(4 * t);
    const Measured now = flight.measure(t);
    if (k > 100) {
      const auto measured = now.measured.subspan(late), truth = now.truth.subspan(late);
      EXPECT_NEAR(measured[a_f], truth[a_f], 1e-3) << t;
      EXPECT_NEAR(measured[a_s], truth[a_s], 1e-3) << t;
      EXPECT_NEAR(measured[r], truth[r], 0.05) << t;
      greatest = std::max(greatest, std::abs(truth[a_f]));
    }
    const std::vector<double> u = {0, 0, 0, 0, push, -push, 0.0, push};
    EXPECT_TRUE(flight.apply(t, now.measured, u));
  }
  EXPECT_GT(greatest, 0.2);
}

TEST(Localizer, SameSeedSameBits) {
  const auto end = [](std::uint64_t seed) {
    auto flight = localized(3, FilterKind::heading, seed);
    return fly_localized(flight, 6.0).end;
  };
  const std::vector<double> first = end(5);
  EXPECT_EQ(first, end(5));
  EXPECT_NE(first, end(6));
}

TEST(Localizer, OneThatComesAgainBeginsAnew) {
  auto flight = localized(2, FilterKind::heading, 6);
  std::vector<double> u(8);
  const auto until = [&](double from, double end) {
    for (double t = from; t < end; t += flight_period) {
      const Measured now = flight.measure(t);
      (void)flight.apply(t, now.measured, u);
    }
  };
  until(0.0, 1.0);
  EXPECT_TRUE(flight.estimate(1).known);
  const auto now = [&](Presence of_uav1) {
    const std::vector presence{Presence::steered, of_uav1};
    flight.world->set_presence(presence);
    flight.localizer->set_presence(presence);
  };
  now(Presence::absent);
  EXPECT_FALSE(flight.estimate(1).known);
  now(Presence::steered);
  EXPECT_EQ(flight.measure(1.0).stamps[1], -std::numeric_limits<double>::infinity());
  until(1.0, 2.0);
  EXPECT_TRUE(flight.estimate(1).known);
}

/// Spoils what is measured of the state of uav1.
class SpoiledWorld final : public World {
 public:
  SpoiledWorld(World& world, double by) : world_(world), by_(by) {}
  const Team& team() const noexcept override { return world_.team(); }
  std::span<const double> start() const noexcept override { return world_.start(); }
  MeasuredMost measured_max() const noexcept override { return world_.measured_max(); }
  void set_presence(std::span<const Presence> presence) noexcept override { world_.set_presence(presence); }
  Measured measure(double t) noexcept override {
    Measured now = world_.measure(t);
    spoiled_.assign(now.measured.begin(), now.measured.end());
    stamps_.assign(now.stamps.begin(), now.stamps.end());
    for (std::size_t i = 7; i < 14; ++i) spoiled_[i] = by_ * spoiled_[i] + by_;
    stamps_[1] = by_;
    now.measured = spoiled_;
    now.stamps = stamps_;
    return now;
  }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override {
    return world_.apply(t, estimated, u, period, periods);
  }

 private:
  World& world_;
  double by_;
  std::vector<double> spoiled_, stamps_;
};

/// Commands of a guarded loop in a world where the state of uav1 is measured with that error, and
/// estimates of uav1.
std::vector<double> commands_with(double spoiled_by) {
  auto flight = localized(2, FilterKind::heading, 7);
  SpoiledWorld world(*flight.world, spoiled_by);
  NewtonRiccati solver(Ocp(world.team(), {.T = 1.0, .N = 20, .dt = flight_period}));
  Guard guard(world.team(), {.supervisor = SupervisorOptions{}, .barrier = BarrierMode::on});
  test::AllSamples samples(sized_sample(world, {solver}));
  SimulatedClock clock;
  (void)Loop(world, {solver}, clock, samples,
             {.duration = 4.0, .guard = &guard, .localizer = flight.localizer.get()})
      .run();
  std::vector<double> all;
  for (const Sample& sample : samples.all) {
    all.insert(all.end(), sample.u.begin(), sample.u.end());
    const PoseEstimate& estimate = sample.estimates[1];
    all.insert(all.end(), {estimate.p.x, estimate.p.y, estimate.p.z, estimate.psi, estimate.P(0, 0)});
  }
  EXPECT_TRUE(samples.all.back().estimates[1].known);
  EXPECT_FALSE(samples.all.back().estimates[0].known) << "it is measured";
  return all;
}

TEST(Localizer, WhatIsMeasuredOfALocalizedRobotChangesNothing) {
  const std::vector<double> commands = commands_with(0.0);
  EXPECT_EQ(commands, commands_with(1e3));
  EXPECT_EQ(commands, commands_with(std::numeric_limits<double>::quiet_NaN()));
}

TEST(Localizer, TheDeviationOfABodyIsZeroWhereItIsMeasuredAndInfiniteWhereNothingIsKnown) {
  auto flight = localized(2, FilterKind::heading, 3);
  const Measured first = flight.measure(0.0);
  EXPECT_EQ(first.stamps[0], 0.0);
  EXPECT_EQ(first.stamps[1], -std::numeric_limits<double>::infinity());
  EXPECT_FALSE(flight.estimate(1).known);
  EXPECT_EQ(flight.localizer->sigma()[0], 0.0);
  EXPECT_EQ(flight.localizer->sigma()[1], std::numeric_limits<double>::infinity());
  EXPECT_FALSE(flight.localizer->knows_all());
  (void)fly_localized(flight, 2.0);
  EXPECT_GT(flight.localizer->sigma()[1], 1e-3);
  EXPECT_LT(flight.localizer->sigma()[1], 0.1);
  EXPECT_EQ(flight.localizer->sigma()[1], flight.estimate(1).position_sigma());
}

TEST(Localizer, EachDetectionHasItsVerdict) {
  auto flight = localized(2, FilterKind::heading, 3);
  int accepted = 0, started = 0;
  for (int k = 0; k < 200; ++k) {
    const Measured now = flight.measure(k * flight_period);
    EXPECT_LE(flight.localizer->fits().size(), now.detections.size());
    for (const DetectionFit& one : flight.localizer->fits()) {
      EXPECT_EQ(one.observer, BodyId{1});
      EXPECT_EQ(one.target, BodyId{0});
      accepted += one.fit.verdict == FitVerdict::accepted ? 1 : 0;
      started += one.fit.verdict == FitVerdict::started ? 1 : 0;
    }
    (void)flight.apply(k * flight_period, now.measured, std::vector<double>(8));
  }
  EXPECT_EQ(started, 1);
  EXPECT_GT(accepted, 40);
}

TEST(Localizer, WhatCannotBeLocalizedIsRefused) {
  const auto refused = [](const LocalizerOptions& options) {
    return refusal_of([&] { Localizer(followers(3), in_a_row(3), options); });
  };
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{1}, .observes = {BodyId{0}}},
                                {.robot = BodyId{2},
                                 .observes = {BodyId{1}},
                                 .filter = {.filter = FilterKind::attitude}}}}),
            "\"uav2\" observes \"uav1\", which is localized itself, with the filter \"attitude\", expected "
            "\"heading\"");
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{1}, .observes = {BodyId{0}}, .camera_rate = 0.0}}}),
            "estimate.camera_rate = 0, expected > 0 Hz");
  EXPECT_EQ(refused({.robots = {{.robot = BodyId{7}, .observes = {BodyId{0}}}}}),
            "a robot that is localized has the number 7, expected one of 3 bodies");
}

}  // namespace
}  // namespace sightline
