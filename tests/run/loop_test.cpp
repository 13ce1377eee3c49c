#include "sightline/loop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <stdexcept>
#include <thread>

#include "sightline/solver.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/counted_new.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using Numbers = std::vector<double>;

// Pulls each robot to the origin by itself; predicts the states times (stage + 1).
class Puller : public Solver {
 public:
  explicit Puller(Team team, const Horizon& horizon = {.T = 0.5, .N = 5, .dt = 0.01})
      : ocp_(std::move(team), horizon),
        u_(static_cast<std::size_t>(ocp_.nu())),
        x_(static_cast<std::size_t>((horizon.N + 1) * ocp_.nx())) {}

  std::string_view name() const override { return "puller"; }
  const Ocp& ocp() const override { return ocp_; }
  double kkt(double, std::span<const double>) noexcept override { return 0.0; }
  void planned(double, std::span<double> u) const noexcept override {
    std::copy(u_.begin(), u_.end(), u.begin());
  }
  void restart() noexcept override {}
  Solution solve(double time, std::span<const double> states) noexcept override {
    last_states.assign(states.begin(), states.end());
    for (const BodyId body : ocp_.agent_bodies()) {
      const auto at = static_cast<std::size_t>(ocp_.team().state_offset(body));
      const auto to = static_cast<std::size_t>(ocp_.team().input_offset(body));
      u_[to] = std::clamp(-0.5 * states[at], -1.0, 1.0);
      u_[to + 1] = std::clamp(0.4 * states[at + 1], -1.0, 1.0);
      u_[to + 2] = std::clamp(0.3 - 0.3 * states[at + 2], -1.0, 1.0);
      u_[to + 3] = 0.2;
    }
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const std::size_t stage = i / states.size() + 1;
      x_[i] = static_cast<double>(stage) * states[i % states.size()];
    }
    Solution solution{.u = u_, .raw_u = u_, .x = x_};
    spoil(time, solution);
    return solution;
  }

  Numbers last_states = Numbers(1000);

 protected:
  virtual void spoil(double, Solution&) noexcept {}
  Ocp ocp_;
  Numbers u_, x_;
};

// Spoils what it returns in one period of three, each time in another way.
class Spoiler : public Puller {
 public:
  using Puller::Puller;

 protected:
  void spoil(double time, Solution& solution) noexcept override {
    const int k = static_cast<int>(std::lround(time / 0.01));
    if (k % 3 != 0) return;
    solution.status = Status::not_finite;
    const double bad[] = {std::nan(""), 1.0 + 1e-12, -std::numeric_limits<double>::infinity(), 40.0};
    u_[static_cast<std::size_t>(k / 3) % 4] = bad[(k / 12) % 4];
    if (k % 2 == 0) solution.u = {};
    x_.back() = std::nan("");
  }
};

Team robots(std::initializer_list<const char*> names, std::initializer_list<const char*> obstacles = {}) {
  Team team;
  for (const char* name : names) team.add(Multirotor{}, {.name = name});
  for (const char* name : obstacles) team.add(Obstacle{.name = name});
  return team;
}
const Numbers start_a = {-0.6, -0.3, 0.6, 1, 0, 0.1, 0}, start_b = {2, 1, 0.5, 0, 1, 0, -0.2};
const Numbers wall = {5, 6, 7, 0.1, 0.2, 0.3};

Numbers joined(const Numbers& a, const Numbers& b) {
  Numbers all = a;
  all.insert(all.end(), b.begin(), b.end());
  return all;
}

struct Flight {
  std::vector<Sample> samples;
  LoopOutcome outcome;
};

// The loop, with a log thread that keeps all samples.
Flight fly(const Team& team, const Numbers& x0, const Controllers& controllers, const LoopOptions& options,
           Clock&& clock = SimulatedClock(), std::size_t capacity = 4) {
  ModelWorld world(team, x0);
  SpscQueue<Sample> ring(capacity, sized_sample(team, controllers));
  Loop loop(world, controllers, clock, ring, options);
  Flight flight;
  std::thread log([&] {
    while (const Sample* sample = ring.wait()) {
      flight.samples.push_back(*sample);
      ring.pop();
    }
  });
  flight.outcome = loop.run();
  log.join();
  return flight;
}

std::string refusal(const Team& team, const Numbers& x0, const Controllers& controllers,
                    const LoopOptions& options = {}) {
  return refusal_of([&] { fly(team, x0, controllers, options); });
}

TEST(Loop, IsMeasureSolveApplyOncePerPeriod) {
  const Team team = robots({"a", "b"});
  const Numbers x0 = joined(start_a, start_b);
  Puller puller(team), again(team);
  const Flight flight = fly(team, x0, {puller}, {.duration = 3.0});
  Plant plant(team, x0);
  ASSERT_EQ(flight.samples.size(), 300U);
  EXPECT_EQ(flight.outcome.updates, 300);
  for (int k = 0; k < 300; ++k) {
    const Sample& sample = flight.samples[static_cast<std::size_t>(k)];
    ASSERT_EQ(sample.time, k * 0.01);
    ASSERT_THAT(sample.x, testing::ElementsAreArray(plant.x()));
    ASSERT_EQ(sample.measured, sample.x);
    const auto u = again.step(k * 0.01, plant.x());
    ASSERT_THAT(sample.u, testing::ElementsAreArray(u));
    ASSERT_EQ(sample.raw_u, sample.u);
    ASSERT_EQ(sample.event_count, 0);
    plant.step(u, 0.01);
  }
}

TEST(Loop, RoundsTheDurationToPeriods) {
  const Team team = robots({"a"});
  Puller puller(team);
  for (const auto& [duration, updates] :
       {std::pair{0.1, 10}, {0.104, 10}, {0.106, 11}, {0.29, 29}, {0.001, 0}}) {
    EXPECT_EQ(fly(team, start_a, {puller}, {.duration = duration}).outcome.updates, updates) << duration;
  }
}

TEST(Loop, TwoControllersOfUncoupledRobotsFlyAsOneJointController) {
  const Team team = robots({"a", "b"}, {"wall"});
  const Numbers x0 = joined(joined(start_a, start_b), wall);
  Puller joint(robots({"b", "a"})), alone_a(robots({"a"})), alone_b(robots({"b"}, {"wall"}));
  const Flight one = fly(team, x0, {joint}, {.duration = 2.0});
  const Flight two = fly(team, x0, {alone_b, alone_a}, {.duration = 2.0});
  ASSERT_EQ(one.samples.size(), two.samples.size());
  for (std::size_t k = 0; k < one.samples.size(); ++k) {
    ASSERT_EQ(one.samples[k].x, two.samples[k].x);
    ASSERT_EQ(one.samples[k].u, two.samples[k].u);
    ASSERT_EQ(two.samples[k].solvers.size(), 2U);
  }
}

TEST(Loop, ARobotOfAnotherControllerIsSeenAsPositionAndVelocity) {
  const Team team = robots({"a", "b"}, {"wall"});
  const Numbers x0 = joined(joined(start_a, start_b), wall);
  Puller for_a(robots({"a"}, {"b", "wall"})), for_b(robots({"b"}));
  const Flight flight = fly(team, x0, {for_a, for_b}, {.duration = 1.0});
  const Sample& last = flight.samples.back();
  const Sample& before = flight.samples[flight.samples.size() - 2];
  const Sight<double> b = team.model(BodyId{1}).sight(&last.x[7], &before.u[4]);
  const Numbers seen = {b.p.x, b.p.y, b.p.z, b.v.x, b.v.y, b.v.z};
  EXPECT_THAT(Numbers(for_a.last_states.begin() + 7, for_a.last_states.begin() + 13),
              testing::ElementsAreArray(seen));
  EXPECT_THAT(Numbers(for_a.last_states.begin() + 13, for_a.last_states.end()),
              testing::ElementsAreArray(Numbers(last.x.begin() + 14, last.x.end())));
}

TEST(Loop, WhatIsNotFiniteOrAboveItsLimitNeverReachesThePlant) {
  const Team team = robots({"a"});
  Spoiler spoiler(team);
  const Flight flight = fly(team, start_a, {spoiler}, {.duration = 5.0, .path_interval = 0.03});
  Numbers held(4, 0.0);
  std::int64_t refused = 0;
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const Sample& sample = flight.samples[k];
    for (const double u : sample.u) ASSERT_LE(std::abs(u), 1.0);
    ASSERT_TRUE(all_finite(sample.u));
    ASSERT_TRUE(all_finite(sample.x));
    ASSERT_TRUE(all_finite(sample.path));
    const auto events = std::span(sample.events).first(static_cast<std::size_t>(sample.event_count));
    const bool reported = std::any_of(events.begin(), events.end(),
                                      [](const Event& e) { return e.kind == EventKind::input_refused; });
    ASSERT_EQ(reported, k % 3 == 0) << k;
    if (reported) {
      ASSERT_EQ(sample.u, held) << "the last good one is held";
    }
    held = sample.u;
    refused += reported ? 1 : 0;
  }
  EXPECT_EQ(flight.outcome.refused, refused);
  EXPECT_TRUE(flight.outcome.finite);
}

TEST(Loop, AChangeOfStatusIsAnEvent) {
  const Team team = robots({"a"});
  Spoiler spoiler(team);
  const Flight flight = fly(team, start_a, {spoiler}, {.duration = 1.0});
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const Sample& sample = flight.samples[k];
    EXPECT_EQ(sample.solvers[0].status, k % 3 == 0 ? Status::not_finite : Status::iteration_limit);
    int reported = 0;
    for (int e = 0; e < sample.event_count; ++e) {
      const Event& event = sample.events[static_cast<std::size_t>(e)];
      if (event.kind != EventKind::solver_status) continue;
      ++reported;
      EXPECT_EQ(event.time, sample.time);
      EXPECT_EQ(event.value, static_cast<double>(sample.solvers[0].status));
    }
    EXPECT_EQ(reported, k > 0 && k % 3 != 2 ? 1 : 0) << k;
  }
}

TEST(Loop, TimeVaryingLimitsHoldForWhatIsHeldToo) {
  Team team;
  team.add(Agent{.name = "a",
                 .model = Multirotor{},
                 .Q = Numbers(7, 0.0),
                 .R = Numbers(4, 1.0),
                 .Q_f = {},
                 .limits = InputLimits({0.0, 0.5}, {Numbers(4, -1.0), Numbers(4, -0.05)},
                                       {Numbers(4, 1.0), Numbers(4, 0.05)})});
  Puller puller(team);
  const Flight flight = fly(team, start_a, {puller}, {.duration = 1.0});
  for (const Sample& sample : flight.samples) {
    for (const double u : sample.u) ASSERT_LE(std::abs(u), sample.time < 0.4999 ? 1.0 : 0.05);
  }
  EXPECT_EQ(flight.outcome.refused, 50);
}

TEST(Loop, NothingInItAllocates) {
  ASSERT_GT(
      [] {
        const Numbers some(3);
        return allocations_here();
      }(),
      0)
      << "the counter counts";
  const Team team = robots({"a", "b"}, {"wall"});
  const PlantOptions options{
      .disturbances = {
          .gust_sigma = 0.1, .airflow = {.amplitude = 0.15}, .input_delay = 0.06, .yaw_lag = 0.2}};
  ModelWorld world(
      team, joined(joined(start_a, start_b), wall), options,
      {.noise = {.position = 0.005, .heading = 0.01},
       .delay = 0.03,
       .faults = {{.kind = FaultKind::nan, .probability = 0.3}, {.kind = FaultKind::freeze, .from = 5}}});
  Guard guard(team, {.supervisor = SupervisorOptions{}, .barrier = BarrierMode::on});
  Spoiler for_a(robots({"a"}, {"b"}));
  Puller for_b(robots({"b"}, {"wall"}));
  const Controllers controllers = {for_a, for_b};
  SpscQueue<Sample> ring(1000, sized_sample(team, controllers));
  SimulatedClock clock;
  Loop loop(world, controllers, clock, ring,
            {.duration = 10.0,
             .allocations = allocations_here,
             .guard = &guard,
             .late_plans = {{.from = 2.0, .until = 3.0}}});
  const std::int64_t before = allocations_here();
  const LoopOutcome outcome = loop.run();
  EXPECT_EQ(allocations_here(), before);
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_EQ(outcome.updates, 1000);
}

TEST(Loop, AllocationsOfASolverAreCounted) {
  class Allocator : public Puller {
   public:
    using Puller::Puller;

   protected:
    void spoil(double time, Solution&) noexcept override {
      if (time == 0.02) kept.assign(100, 1.0);
    }
    Numbers kept;
  };
  const Team team = robots({"a", "b"});
  Puller puller(robots({"a"}));
  Allocator allocator(robots({"b"}));
  const Flight flight = fly(team, joined(start_a, start_b), {puller, allocator},
                            {.duration = 0.05, .allocations = allocations_here});
  EXPECT_EQ(flight.outcome.max_allocations, 1);
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    EXPECT_EQ(flight.samples[k].solvers[0].allocations, 0);
    EXPECT_EQ(flight.samples[k].solvers[1].allocations, k == 2 ? 1 : 0);
  }
}

TEST(Loop, PredictedPathsComeAtTheirIntervalInThePlantsOrder) {
  const Team team = robots({"a", "b"}, {"wall"});
  const Numbers x0 = joined(joined(start_a, start_b), wall);
  Puller for_b(robots({"b"})), for_a(robots({"a"}), {.T = 0.4, .N = 2, .dt = 0.01});
  const Flight flight = fly(team, x0, {for_b, for_a}, {.duration = 1.0, .path_interval = 0.25});
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    const Sample& sample = flight.samples[k];
    ASSERT_EQ(sample.has_path, k % 25 == 0);
    ASSERT_EQ(sample.path_step, 0.1);
    ASSERT_EQ(sample.path.size(), 6U * 20U);
    if (!sample.has_path) continue;
    for (std::size_t i = 0; i < 6; ++i) {
      const double at = std::min(static_cast<double>(i) / 2, 2.0);  // of the stages of 0.2 s
      for (std::size_t q = 0; q < 20; ++q) {
        const double factor = q < 7 ? at + 1 : q < 14 ? static_cast<double>(i + 1) : 1.0;
        ASSERT_NEAR(sample.path[20 * i + q], factor * sample.x[q], 1e-12) << i << " " << q;
      }
    }
  }
  const Flight none = fly(team, x0, {for_b, for_a}, {.duration = 1.0, .path_interval = 0});
  for (const Sample& sample : none.samples) EXPECT_FALSE(sample.has_path);
}

TEST(Loop, TheStopFlagEndsItAtTheNextPeriod) {
  static std::atomic<bool> stop;
  stop = false;
  class Stopper : public Puller {
   public:
    using Puller::Puller;

   protected:
    void spoil(double time, Solution&) noexcept override {
      if (time > 0.095) stop = true;
    }
  };
  const Team team = robots({"a"});
  Stopper stopper(team);
  const Flight flight = fly(team, start_a, {stopper}, {.duration = 100.0, .stop = &stop});
  EXPECT_TRUE(flight.outcome.stopped);
  EXPECT_EQ(flight.samples.size(), 11U);
}

// A clock that says beforehand which periods are missed, and is in no hurry otherwise.
class Stumbling : public Clock {
 public:
  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override { return k % 10 == 7 ? k + 2 : k; }
  bool waits_for_log() const noexcept override { return false; }
};

TEST(Loop, OverMissedPeriodsThePlantGoesOnUnderTheCommandItHadAndAnEventTells) {
  const Team team = robots({"a"});
  Puller puller(team), again(team);
  const Flight flight = fly(team, start_a, {puller}, {.duration = 1.0}, Stumbling(), 200);
  EXPECT_EQ(flight.outcome.missed, 20);
  EXPECT_EQ(flight.outcome.updates, 80);
  Plant plant(team, start_a);
  Numbers u(4);
  std::size_t s = 0;
  for (int k = 0; k < 100; ++k) {
    if (k % 10 != 7 && k % 10 != 8) {
      const Sample& sample = flight.samples[s++];
      ASSERT_DOUBLE_EQ(sample.time, 0.01 * k);
      ASSERT_THAT(sample.x, testing::ElementsAreArray(plant.x())) << k;
      ASSERT_EQ(sample.event_count, k % 10 == 9 ? 1 : 0);
      if (k % 10 == 9) {
        ASSERT_EQ(sample.events[0].kind, EventKind::missed_period);
        ASSERT_EQ(sample.events[0].value, 2.0);
      }
      const auto command = again.step(sample.time, plant.x());
      u.assign(command.begin(), command.end());
    }
    plant.step(u, 0.01);
  }
}

TEST(Loop, AClockThatWaitsForNobodyDropsAndCountsWhatTheRingCannotTake) {
  const Team team = robots({"a"});
  Puller puller(team);
  ModelWorld world(team, start_a);
  SpscQueue<Sample> ring(10, sized_sample(team, {puller}));
  class Hurrying : public Stumbling {
   public:
    explicit Hurrying(SpscQueue<Sample>& r) : ring_(r) {}
    std::int64_t wait(std::int64_t k) noexcept override {
      if (k == 50) ring_.pop();  // room for one again
      return k;
    }

   private:
    SpscQueue<Sample>& ring_;
  } clock(ring);
  Loop loop(world, {puller}, clock, ring, {.duration = 1.0});
  const LoopOutcome outcome = loop.run();
  EXPECT_EQ(outcome.updates, 100);
  EXPECT_EQ(outcome.dropped, 89);
  const Sample* last = nullptr;
  for (int i = 0; i < 10; ++i) {
    last = ring.wait();
    ASSERT_NE(last, nullptr);
    ring.pop();
  }
  EXPECT_EQ(ring.wait(), nullptr);
  EXPECT_DOUBLE_EQ(last->time, 0.5);
  ASSERT_EQ(last->event_count, 1);
  EXPECT_EQ(last->events[0].kind, EventKind::samples_dropped);
  EXPECT_EQ(last->events[0].value, 40.0);
}

TEST(Loop, ASteadyClockCarriesTheSameFlight) {
  const Team team = robots({"a"});
  Puller puller(team);
  const Flight paced = fly(team, start_a, {puller}, {.duration = 0.1}, SteadyClock(), 100);
  EXPECT_EQ(paced.outcome.updates + paced.outcome.missed, 10);
  EXPECT_EQ(static_cast<std::int64_t>(paced.samples.size()) + paced.outcome.dropped, paced.outcome.updates);
  EXPECT_EQ(paced.samples[0].x, start_a);
}

// A robot that leaves the numbers behind within a few steps.
struct Exploding : Multirotor {
  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    auto rate = Multirotor::f(x, u);
    rate[0] = 1e80 * (1.0 + square(x[0]));
    return rate;
  }
};

TEST(Loop, APlantThatIsNoLongerFiniteEndsTheRunAndStaysOutOfTheLog) {
  Team team;
  team.add(Exploding{}, {.name = "a"});
  Puller puller(team);
  const Flight flight = fly(team, start_a, {puller}, {.duration = 10.0});
  EXPECT_FALSE(flight.outcome.finite);
  EXPECT_LT(flight.outcome.updates, 1000);
  for (const Sample& sample : flight.samples) EXPECT_TRUE(all_finite(sample.x));
}

TEST(Loop, EachRobotIsSteeredByExactlyOneControllerAndKnownToThePlant) {
  const Team pair = robots({"a", "b"}, {"wall"});
  const Numbers x0 = joined(joined(start_a, start_b), wall);
  Puller a(robots({"a"})), b(robots({"b"})), both(robots({"a", "b"})), uncooperative(robots({"a", "b", "c"}));
  Puller takes_wall(robots({"a", "b", "wall"})), slow(robots({"a", "b"}), {.T = 1, .N = 5, .dt = 0.02});
  EXPECT_EQ(refusal(pair, x0, {a, b}, {.duration = 0.02}), "");
  EXPECT_EQ(refusal(pair, x0, {}), "the loop has no controller, expected at least one");
  EXPECT_EQ(refusal(pair, x0, {a}), "\"b\" is steered by no controller, expected one whose team has it");
  EXPECT_EQ(refusal(pair, x0, {a, both}), "\"a\" is steered by controllers 0 and 1, expected one");
  EXPECT_EQ(refusal(pair, x0, {uncooperative}),
            "controller 0: \"c\" is not in the plant, expected one of its bodies");
  EXPECT_EQ(refusal(pair, x0, {takes_wall}),
            "controller 0: \"wall\" is an obstacle of the plant, expected a robot");
  EXPECT_EQ(refusal(pair, x0, {slow}), "controller 0: horizon.period = 0.02, expected the loop's 0.01");
  Team angle;
  angle.add(AngleMultirotor{}, {.name = "a"});
  Puller wrong_model(angle);
  EXPECT_EQ(
      refusal(pair, x0, {wrong_model, b}),
      "controller 0: \"a\" is of model angle_multirotor (6 states), expected the plant's multirotor (7)");
  EXPECT_THAT(refusal(pair, x0, {both}, {.duration = -1}),
              testing::StartsWith("loop.duration = -1, expected"));
  EXPECT_THAT(refusal(pair, x0, {both}, {.period = 0}), testing::StartsWith("loop.period = 0, expected"));
  EXPECT_THAT(refusal(pair, x0, {both}, {.path_interval = -1}),
              testing::StartsWith("loop.path_interval = -1"));
}

TEST(Loop, ARingOfSamplesOfAnotherSizeIsRefused) {
  const Team team = robots({"a"});
  Puller puller(team);
  ModelWorld world(team, start_a);
  SimulatedClock clock;
  SpscQueue<Sample> unsized(4, Sample{}), sized(4, sized_sample(team, {puller}));
  EXPECT_THROW(Loop(world, {puller}, clock, unsized, {}), std::invalid_argument);
  EXPECT_NO_THROW(Loop(world, {puller}, clock, sized, {}));
}

}  // namespace
}  // namespace sightline
