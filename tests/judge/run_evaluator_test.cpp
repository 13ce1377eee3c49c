#include "sightline/judge/run_evaluator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <type_traits>

#include "sightline/potentials.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/period.hpp"

namespace sightline {
namespace {

using test::control_period;

/// One robot looks at a target; it is put where a test wants it.
class EvaluatedRun {
 public:
  /// @param d_hard  that the scenario itself asks for [m]
  /// @param walls   that it asks for
  /// @param barrier  that it has
  explicit EvaluatedRun(CampaignPlan plan, std::optional<double> d_hard = {}, std::optional<Walls> walls = {},
                        BarrierMode barrier = BarrierMode::off)
      : plan_(std::move(plan)) {
    if (walls || barrier != BarrierMode::off) scenario_.safety.emplace().barrier = barrier;
    if (walls) scenario_.safety->judged = *walls;
    const AgentId seer = scenario_.team.add(Multirotor{}, {.R = {1, 2, 3, 4}, .name = "seer"});
    const BodyId tag = scenario_.team.add(Obstacle{"tag"});
    scenario_.uncooperative.push_back({.body = tag, .d_hard = d_hard});
    scenario_.team.couple(1.0 * Bearing{.alpha = 0.5}, Between{seer, tag});
    Sample sample;
    sample.x = {0, 0, 1, 1, 0, 0, 0, 2, 0, 1, 0, 0, 0};
    sample.u = sample.raw_u = {0, 0, 0, 0};
    sample.measured = sample.x;
    sample.presence = {Presence::steered, Presence::hold};
    sample.solvers.resize(1);
    judge_.emplace(scenario_, plan_, sample);
  }

  /// A period with the target `distance` ahead, or behind where that is negative.
  void fly(double distance, double u_f = 0.0, double v_f = 0.0) {
    Sample& sample = *judge_->claim();
    sample.time = control_period * static_cast<double>(updates_++);
    sample.x[7] = distance;
    sample.x[5] = v_f;
    sample.u[0] = u_f;
    judge_->publish();
  }
  void fly_to_end(double distance) {
    while (updates_ < std::llround(plan_.duration / control_period)) fly(distance);
  }
  RunResult result(bool finite = true, const std::string& ended = {}) {
    LoopOutcome outcome;
    outcome.updates = updates_;
    outcome.finite = finite;
    return judge_->result(outcome, ended);
  }
  Sample& sample() { return *judge_->claim(); }

 private:
  CampaignPlan plan_;
  Scenario scenario_;
  std::optional<RunEvaluator> judge_;
  std::int64_t updates_ = 0;
};

CampaignPlan judged_plan() { return {.duration = 1.0, .view_within = 0.5, .d_hard = 0.6, .braking = 0.6}; }

// What points into itself stays where it is.
template <class... Owners>
constexpr bool all_stay = ((!std::is_copy_constructible_v<Owners> && !std::is_move_constructible_v<Owners> &&
                            !std::is_copy_assignable_v<Owners> && !std::is_move_assignable_v<Owners>)&&...);
static_assert(all_stay<Guard, Supervisor, Search, Loop, ClosedLoop, RunEvaluator, TeamSwitcher, ThreadPool,
                       ServiceThread>);

TEST(RunEvaluator, InViewInTimeAndAtTheEndIsRecovered) {
  EvaluatedRun flown(judged_plan());
  for (int i = 0; i < 30; ++i) flown.fly(-2.0);
  for (int i = 0; i < 30; ++i) flown.fly(2.0);
  for (int i = 0; i < 20; ++i) flown.fly(-3.0);  // may be out of view on the way
  flown.fly_to_end(1.5);
  const RunResult result = flown.result();
  EXPECT_EQ(result.outcome, Outcome::recovered);
  EXPECT_NEAR(result.time_to_first_view, 0.3, 1e-9);
  EXPECT_NEAR(result.fraction_in_view, 0.5, 1e-9);
  EXPECT_EQ(result.min_distance, 1.5);
  EXPECT_EQ(result.violations, 0);
}

TEST(RunEvaluator, TooLateNotAtTheEndAndNeverAreLost) {
  EvaluatedRun late(judged_plan()), gone(judged_plan()), never(judged_plan());
  for (int i = 0; i < 51; ++i) late.fly(-2.0);
  late.fly_to_end(2.0);
  for (int i = 0; i < 99; ++i) gone.fly(2.0);
  gone.fly_to_end(-2.0);
  never.fly_to_end(-2.0);
  EXPECT_EQ(late.result().outcome, Outcome::lost);
  EXPECT_NEAR(late.result().time_to_first_view, 0.51, 1e-9);
  EXPECT_EQ(gone.result().outcome, Outcome::lost);
  EXPECT_EQ(gone.result().time_to_first_view, 0.0);
  EXPECT_EQ(never.result().outcome, Outcome::lost);
  EXPECT_TRUE(std::isnan(never.result().time_to_first_view));
}

TEST(RunEvaluator, NearerThanTheHardDistanceIsTooCloseWhereTheStartAllowedToBrake) {
  EvaluatedRun close(judged_plan());
  close.fly(2.0);
  for (int i = 0; i < 3; ++i) close.fly(0.5);
  close.fly_to_end(2.0);
  EXPECT_EQ(close.result().outcome, Outcome::too_close);
  EXPECT_EQ(close.result().violations, 3);
  EXPECT_EQ(close.result().min_distance, 0.5);

  // From 0.5 m it could not; nor at 1.2 m/s with less than 1.2^2 / (2 0.6) = 1.2 m to go.
  EvaluatedRun near(judged_plan()), fast(judged_plan()), slower(judged_plan());
  near.fly_to_end(0.5);
  fast.fly(0.6 + 1.19, 0.0, 1.2);
  fast.fly(0.5);
  fast.fly_to_end(2.0);
  slower.fly(0.6 + 1.21, 0.0, 1.2);
  slower.fly(0.5);
  slower.fly_to_end(2.0);
  EXPECT_FALSE(near.result().could_brake);
  EXPECT_EQ(near.result().outcome, Outcome::recovered);
  EXPECT_EQ(near.result().violations, 0);
  EvaluatedRun parting(judged_plan());
  parting.fly(0.7, 0.0, -1.2);
  parting.fly(0.5);
  parting.fly_to_end(2.0);
  EXPECT_EQ(parting.result().outcome, Outcome::too_close);
  EXPECT_FALSE(fast.result().could_brake);
  EXPECT_EQ(fast.result().outcome, Outcome::recovered);
  EXPECT_TRUE(slower.result().could_brake);
  EXPECT_EQ(slower.result().outcome, Outcome::too_close);
}

TEST(RunEvaluator, TheHardDistanceOfTheScenarioCountsBeforeThatOfTheCampaign) {
  EvaluatedRun wider(judged_plan(), 1.0), narrower(judged_plan(), 0.3);
  for (EvaluatedRun* flown : {&wider, &narrower}) {
    flown->fly(2.0);
    flown->fly(0.7);
    flown->fly(0.5);
    flown->fly_to_end(2.0);
  }
  EXPECT_EQ(wider.result().outcome, Outcome::too_close);
  EXPECT_EQ(wider.result().violations, 2);
  EXPECT_EQ(narrower.result().outcome, Outcome::recovered);
}

TEST(RunEvaluator, WithoutAHardDistanceNothingIsTooClose) {
  CampaignPlan free = judged_plan();
  free.d_hard = 0.0;
  EvaluatedRun flown(free);
  flown.fly(2.0);
  flown.fly(0.01);
  flown.fly_to_end(2.0);
  EXPECT_EQ(flown.result().outcome, Outcome::recovered);
  EXPECT_EQ(flown.result().min_distance, 0.01);
}

TEST(RunEvaluator, InputsBeyondTheirLimitsAndWhatIsNotFiniteFail) {
  for (const double u : {1.0000001, -2.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EvaluatedRun flown(judged_plan());
    flown.fly(2.0, u);
    flown.fly_to_end(2.0);
    EXPECT_EQ(flown.result().outcome, Outcome::failed) << u;
    EXPECT_EQ(flown.result().violations, 1) << u;
  }
  EvaluatedRun state(judged_plan()), plant(judged_plan()), short_run(judged_plan());
  state.sample().x[2] = std::nan("");
  state.fly_to_end(2.0);
  EXPECT_EQ(state.result().outcome, Outcome::failed);
  EvaluatedRun raw(judged_plan()), last(judged_plan());
  raw.sample().raw_u[2] = std::nan("");
  raw.fly_to_end(2.0);
  EXPECT_EQ(raw.result().reason, "a state or an input was not finite at 0.00 s") << "as of a run";
  last.fly_to_end(2.0);
  EXPECT_EQ(last.result().outcome, Outcome::recovered);
  last.sample().of = Sample::Of::states;
  last.sample().x[4] = std::nan("");
  last.fly(2.0);
  EXPECT_EQ(last.result().reason, "a state or an input was not finite at 1.00 s");
  plant.fly_to_end(2.0);
  EXPECT_EQ(plant.result(false).outcome, Outcome::failed);
  short_run.fly(2.0);
  EXPECT_EQ(short_run.result().outcome, Outcome::failed) << "broken off";
}

TEST(RunEvaluator, ASolverThatGaveNoPlanForLongerThanHoldAfterFails) {
  for (const int failed : {50, 51}) {
    EvaluatedRun flown(judged_plan());
    for (int i = 0; i < 100; ++i) {
      flown.sample().solvers[0].status = i < failed ? Status::not_finite : Status::stepped;
      flown.fly(2.0);
    }
    EXPECT_EQ(flown.result().outcome, failed > 50 ? Outcome::failed : Outcome::recovered) << failed;
    EXPECT_NEAR(flown.result().longest_without_plan, failed * control_period, 1e-9);
  }
}

TEST(RunEvaluator, AFloorCeilingOrBoundOfTheWorldThatIsBrokenFails) {
  const auto outcome = [](const Walls& walls, std::size_t state, double place) {
    EvaluatedRun flown(judged_plan(), {}, walls);
    flown.fly(2.0);
    flown.sample().x[state] = place;
    flown.fly(state == 0 ? place + 2.0 : 2.0);
    flown.sample().x[0] = 0.0, flown.sample().x[2] = 1.0;
    flown.fly_to_end(2.0);
    return flown.result().outcome;
  };
  EXPECT_EQ(outcome({.floor = 0.5}, 2, 0.501), Outcome::recovered);
  EXPECT_EQ(outcome({.floor = 0.5}, 2, 0.499), Outcome::failed);
  EXPECT_EQ(outcome({.ceiling = 1.5}, 2, 1.499), Outcome::recovered);
  EXPECT_EQ(outcome({.ceiling = 1.5}, 2, 1.501), Outcome::failed);
  EXPECT_EQ(outcome({.world = 3.0}, 0, 2.999), Outcome::recovered);
  EXPECT_EQ(outcome({.world = 3.0}, 0, 3.001), Outcome::failed);
}

TEST(RunEvaluator, AFailedRunSaysWhatWentWrongFirstAndOthersSayNothing) {
  EvaluatedRun good(judged_plan()), lost(judged_plan());
  good.fly_to_end(2.0);
  lost.fly_to_end(-2.0);
  EXPECT_EQ(good.result().reason, "");
  EXPECT_EQ(lost.result().reason, "");

  EvaluatedRun both(judged_plan());
  for (int i = 0; i < 30; ++i) both.fly(2.0);
  both.fly(2.0, 1.5);
  both.sample().x[2] = std::nan("");
  both.fly_to_end(2.0);
  EXPECT_EQ(both.result().reason, "an applied input was beyond its limit at 0.30 s");
  EXPECT_EQ(both.result(false, "seer touched the ground at 0.40 s").reason,
            "seer touched the ground at 0.40 s");

  EvaluatedRun nowhere(judged_plan()), planless(judged_plan()), low(judged_plan(), {}, Walls{.floor = 0.5}),
      brief(judged_plan());
  nowhere.fly(2.0);
  nowhere.fly(2.0, std::nan(""));
  nowhere.fly_to_end(2.0);
  EXPECT_EQ(nowhere.result().reason, "a state or an input was not finite at 0.01 s");
  planless.sample().solvers[0].status = Status::not_finite;
  planless.fly_to_end(2.0);
  EXPECT_EQ(planless.result().reason, "a solver gave no plan for longer than 0.5 s, at 0.50 s");
  low.fly(2.0);
  low.sample().x[2] = 0.4;
  low.fly_to_end(2.0);
  EXPECT_EQ(low.result().reason, "seer came to a height of 0.4 m at 0.01 s, the floor is 0.5 m, for 0.98 s");
  brief.fly(2.0);
  EXPECT_EQ(brief.result().reason, "the run broke off");
}

TEST(RunEvaluator, TheLargestShareOfConflictsOfABarrierIsToldWhereThereIsOne) {
  EvaluatedRun without(judged_plan());
  without.fly_to_end(2.0);
  EXPECT_TRUE(std::isnan(without.result().barrier_conflict));

  EvaluatedRun with(judged_plan(), {}, {}, BarrierMode::on);
  for (int i = 0; i < 100; ++i) {
    with.sample().barriers = {{.active = true, .conflict = i < 25}};
    with.fly(2.0);
  }
  EXPECT_EQ(with.result().barrier_conflict, 0.25);
  EXPECT_EQ(with.result().outcome, Outcome::recovered);
}

TEST(RunEvaluator, ChatterAndDriftAreToldAndAreNoOutcome) {
  CampaignPlan longer = judged_plan();
  longer.duration = 20.0;
  const auto result_of = [&](double climb_rate, double jump) {
    EvaluatedRun flown(longer);
    for (int i = 0; i < 2000; ++i) {
      flown.sample().x[2] = 1.0 + climb_rate * control_period * i;
      flown.fly(2.0, i % 2 == 0 ? jump : 0.0);
    }
    return flown.result();
  };
  EXPECT_EQ(result_of(0.0, 0.0).chatter, 0.0);
  EXPECT_EQ(result_of(0.0, 0.0).drift, 0.0);
  EXPECT_EQ(result_of(0.0, 0.3).chatter, 1.0);
  EXPECT_NEAR(result_of(0.05, 0.0).drift, 0.05, 1e-9);
  EXPECT_EQ(result_of(0.05, 0.3).outcome, Outcome::recovered);
  EvaluatedRun brief(judged_plan());
  brief.fly_to_end(2.0);
  EXPECT_TRUE(std::isnan(brief.result().drift));
}

TEST(RunEvaluator, EnergyAndStatusesAreSummed) {
  EvaluatedRun flown(judged_plan());
  for (int i = 0; i < 100; ++i) {
    flown.sample().u = {0.0, 0.5, -0.25, 1.0};
    flown.sample().solvers[0].status = i % 4 == 0 ? Status::converged : Status::deadline;
    flown.fly(2.0, 0.1);
  }
  const RunResult result = flown.result();
  EXPECT_NEAR(result.energy, 0.01 + 2 * 0.25 + 3 * 0.0625 + 4.0, 1e-12);
  EXPECT_EQ(result.statuses[static_cast<std::size_t>(Status::converged)], 25);
  EXPECT_EQ(result.statuses[static_cast<std::size_t>(Status::deadline)], 75);
}

}  // namespace
}  // namespace sightline
