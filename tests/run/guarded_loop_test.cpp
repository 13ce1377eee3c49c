// The loop with a guard and with late plans; without them it is loop_test.cpp's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/loop.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/period.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline {
namespace {

using test::control_period;
using Numbers = std::vector<double>;

// Plans at t0 the input 0.1 + (t - t0) for every channel, so that each input tells its plan's age.
// Keeps what it was asked.
class ScriptedSolver : public Solver {
 public:
  explicit ScriptedSolver(Team team)
      : ocp_(std::move(team), {.T = 0.5, .N = 5, .dt = control_period}),
        u_(static_cast<std::size_t>(ocp_.nu())) {}

  std::string_view name() const override { return "teller"; }
  const Ocp& ocp() const override { return ocp_; }
  double kkt(double, std::span<const double>) noexcept override { return 0.0; }
  void restart() noexcept override {}
  void planned(double time, std::span<double> u) const noexcept override {
    std::fill(u.begin(), u.end(), 0.1 + time - planned_at_);
  }
  Solution solve(double time, std::span<const double> states) noexcept override {
    requested.push_back(time);
    first_state.push_back(states[0]);
    planned_at_ = time;
    planned(time, u_);
    return {.u = u_, .raw_u = u_, .x = {}, .status = status};
  }

  std::vector<double> requested{}, first_state{};
  Status status = Status::converged;  // of each update

 private:
  Ocp ocp_;
  Numbers u_;
  double planned_at_ = 0.0;
};

Team one_robot() {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  return team;
}
const Numbers start_of_one = {0, 0, 1, 1, 0, 0, 0};

std::vector<Sample> flown_by(ScriptedSolver& solver, LoopOptions options, const SensorOptions& sensing = {}) {
  const Team team = one_robot();
  ModelWorld world(team, start_of_one, {}, sensing);
  const Controllers controllers = {solver};
  SimulatedClock clock;
  test::AllSamples kept(sized_sample(team, controllers));
  Loop loop(world, controllers, clock, kept, options);
  EXPECT_TRUE(loop.run().finite);
  return kept.all;
}

TEST(GuardedLoop, WithGoodDataAGuardLeavesTheFlightAsItIsBitForBit) {
  ScriptedSolver a(one_robot()), b(one_robot());
  Guard guard(one_robot(), {.supervisor = SupervisorOptions{}, .barrier = BarrierMode::on});
  const auto bare = flown_by(a, {.duration = 2.0}), guarded = flown_by(b, {.duration = 2.0, .guard = &guard});
  ASSERT_EQ(bare.size(), guarded.size());
  for (std::size_t k = 0; k < bare.size(); ++k) {
    ASSERT_EQ(bare[k].x, guarded[k].x);
    ASSERT_EQ(bare[k].u, guarded[k].u);
    ASSERT_EQ(guarded[k].event_count, 0);
  }
}

TEST(GuardedLoop, OfALatePlanTheOneBeforeGoesOnAndTheNextUpdateBeginsOnlyWhenItIsDone) {
  ScriptedSolver solver(one_robot());
  const auto samples =
      flown_by(solver, {.duration = 1.0, .late_plans = {{.from = 0.3, .until = 0.6, .delay = 0.05}}});
  Numbers requested;
  for (int k = 0; k < 30; ++k) requested.push_back(control_period * k);
  for (int k = 30; k < 60; k += 6)
    requested.push_back(control_period * k);  // begun, five periods at work, the next begins
  for (int k = 60; k < 100; ++k) requested.push_back(control_period * k);
  ASSERT_EQ(solver.requested.size(), requested.size());
  for (std::size_t i = 0; i < requested.size(); ++i) {
    EXPECT_NEAR(solver.requested[i], requested[i], 1e-12);
    const auto k = static_cast<std::size_t>(std::lround(requested[i] / control_period));
    EXPECT_EQ(solver.first_state[i], samples[k].x[0]) << "from the state of its begin";
  }
  for (int k = 0; k < 100; ++k) {
    const int since = k < 30 || k >= 60 ? 0 : (k - 30) % 6;
    const int age = since == 5 ? 5 : since + (k < 30 || k >= 60 ? 0 : k < 36 ? 1 : 6);  // periods
    const double expected = 0.1 + control_period * age;
    ASSERT_NEAR(samples[static_cast<std::size_t>(k)].u[0], expected, 1e-9) << k;
    const Status status = samples[static_cast<std::size_t>(k)].solvers[0].status;
    ASSERT_EQ(status, since == 5 || k < 30 || k >= 60 ? Status::converged : Status::deadline) << k;
  }
}

TEST(GuardedLoop, APlanThatFailsIsFlownOnThenSlowedThenHeldThenLanded) {
  for (const bool late : {false, true}) {
    ScriptedSolver solver(one_robot());
    Guard guard(one_robot(), {.supervisor = SupervisorOptions{}});
    if (!late) solver.status = Status::not_finite;
    LoopOptions options{.duration = 4.0, .guard = &guard};
    if (late) options.late_plans = {{.from = 0.0, .delay = 10.0}};
    std::vector<EventKind> reported;
    for (const Sample& sample : flown_by(solver, options)) {
      for (int i = 0; i < sample.event_count; ++i) {
        const Event& event = sample.events[static_cast<std::size_t>(i)];
        if (event.kind >= EventKind::valid) reported.push_back(event.kind);
      }
    }
    EXPECT_THAT(reported, testing::ElementsAre(EventKind::predicted, EventKind::slowed, EventKind::hold,
                                               EventKind::land));
  }
}

// An update that the solver's own clock ended is a plan still: 799 of 799 of them landed the
// robots.
TEST(GuardedLoop, OfWhateverStatusAPlanIsFlownAndOnlyWithoutOneTheRobotLands) {
  for (int s = 0; s < status_count; ++s) {
    ScriptedSolver solver(one_robot());
    Guard guard(one_robot(), {.supervisor = SupervisorOptions{}});
    solver.status = static_cast<Status>(s);
    std::vector<EventKind> reported;
    for (const Sample& sample : flown_by(solver, {.duration = 4.0, .guard = &guard})) {
      EXPECT_TRUE(sample.solvers[0].answered);
      for (int i = 0; i < sample.event_count; ++i)
        reported.push_back(sample.events[static_cast<std::size_t>(i)].kind);
    }
    const bool lands = std::find(reported.begin(), reported.end(), EventKind::land) != reported.end();
    EXPECT_EQ(lands, !gives_plan(solver.status)) << to_string(solver.status);
    EXPECT_EQ(reported.empty(), gives_plan(solver.status)) << to_string(solver.status);
  }
}

TEST(GuardedLoop, WhileAnUpdateIsLateTheResidualIsNotKnownAndTheSolverDidNotAnswer) {
  ScriptedSolver solver(one_robot());
  const auto samples =
      flown_by(solver, {.duration = 1.0, .late_plans = {{.from = 0.3, .until = 0.4, .delay = 0.05}}});
  int waiting = 0;
  for (const Sample& sample : samples) {
    const SolverRecord& record = sample.solvers[0];
    EXPECT_EQ(record.answered, record.status != Status::deadline);
    if (record.answered) continue;
    ++waiting;
    EXPECT_EQ(record.residual, std::numeric_limits<double>::infinity());
  }
  EXPECT_GE(waiting, 10);
}

TEST(GuardedLoop, NobodyIsAskedForAPlanBeforeAllBodiesWereSeen) {
  ScriptedSolver solver(one_robot());
  Guard guard(one_robot(), {.supervisor = SupervisorOptions{}, .barrier = BarrierMode::on});
  const SensorOptions blind{.faults = {{.kind = FaultKind::nan, .body = BodyId{0}, .until = 0.5}}};
  const auto samples = flown_by(solver, {.duration = 1.0, .guard = &guard}, blind);
  ASSERT_FALSE(solver.requested.empty());
  EXPECT_NEAR(solver.requested.front(), 0.52, 1e-9) << "the third good measurement";
  for (std::size_t k = 0; k < 52; ++k) {
    for (const double u : samples[k].u) ASSERT_NEAR(u, 0.0, 1e-6);
    ASSERT_EQ(samples[k].solvers[0].status, Status::invalid_state);
  }
}

TEST(GuardedLoop, WhatIsBelievedIsWhatTheControllerSees) {
  ScriptedSolver solver(one_robot());
  Guard guard(one_robot(), {.supervisor = SupervisorOptions{}});
  const auto samples = flown_by(solver, {.duration = 3.0, .guard = &guard}, {.delay = 0.15});
  for (std::size_t k = 20; k < samples.size(); ++k) {
    ASSERT_NEAR(solver.first_state[k], samples[k].x[0], 1e-9) << "the delay is compensated";
    ASSERT_NE(samples[k].measured[0], samples[k].x[0]);
  }
}

}  // namespace
}  // namespace sightline
