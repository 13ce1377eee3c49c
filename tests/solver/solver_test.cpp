// The laws of every solver; a new one is added to the list `Solvers` and inherits them.
#include "sightline/solver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <stdexcept>

#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/error.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using paper::Variant;

/// Every input finite and within the limits of its time.
void expect_usable(const Team& team, double t, std::span<const double> u, const char* where) {
  ASSERT_EQ(static_cast<int>(u.size()), team.nu()) << where;
  std::size_t k = 0;
  for (const Agent& agent : team.agents()) {
    std::vector<double> low(agent.R.size()), high(agent.R.size());
    agent.limits.at(t, low, high);
    for (std::size_t j = 0; j < low.size(); ++j, ++k) {
      EXPECT_TRUE(u[k] >= low[j] && u[k] <= high[j]) << where << ": u[" << k << "] = " << u[k] << " at " << t;
    }
  }
}

/// All inputs of a flight, update after update.
std::vector<double> inputs_of(Solver& solver, const std::vector<double>& start, int updates) {
  std::vector<double> all;
  fly(solver, start, updates, [&](double, const std::vector<double>&, const Solution& s) {
    all.insert(all.end(), s.u.begin(), s.u.end());
  });
  return all;
}

void expect_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) ASSERT_TRUE(same_bits(a[k], b[k])) << "number " << k;
}

template <class S>
class AnySolver : public testing::Test {};

/// A partitioned solver whose robots plan each by itself.
struct EachByItself : PartitionedSolver {
  EachByItself(const Team& team, const Horizon& horizon)
      : PartitionedSolver(team, each(team), newton_riccati_of(horizon)) {}

  static Partition each(const Team& team) {
    Partition parts;
    for (int i = 0; i < team.bodies(); ++i) {
      if (team.is_agent(BodyId{i})) parts.push_back({AgentId{{i}}});
    }
    return parts;
  }
};

using Solvers = testing::Types<Cgmres, Cmscgmres, NewtonRiccati, EachByItself>;
TYPED_TEST_SUITE(AnySolver, Solvers);

TYPED_TEST(AnySolver, GivesInputsAndAPredictionFromTheMeasuredState) {
  for (const int N : {1, 7, 20}) {
    const Team team = paper::team(Variant::masked);
    TypeParam solver(team, {.N = N});
    fly(solver, paper::start(), 100, [&](double t, const std::vector<double>& x, const Solution& s) {
      expect_usable(team, t, s.u, "solve");
      EXPECT_EQ(s.raw_u.size(), 8u);
      ASSERT_EQ(s.x.size(), static_cast<std::size_t>((N + 1) * 14));
      for (std::size_t i = 0; i < 14; ++i) EXPECT_NEAR(s.x[i], x[i], 1e-15);
      EXPECT_TRUE(all_finite(s.x));
      EXPECT_GE(s.residual, 0.0);
      EXPECT_GE(s.elapsed, 0.0);
      EXPECT_TRUE(gives_plan(s.status));
    });
  }
}

TYPED_TEST(AnySolver, InputsAreTheRawOnesClamped) {
  TypeParam solver(paper::team(Variant::joint), {});
  fly(solver, paper::saturating_start(), 300, [&](double, const std::vector<double>&, const Solution& s) {
    for (std::size_t j = 0; j < s.u.size(); ++j)
      EXPECT_EQ(s.u[j], std::fmin(std::fmax(s.raw_u[j], -1.0), 1.0));
  });
}

TYPED_TEST(AnySolver, StepIsSolve) {
  const Team team = paper::team(Variant::masked);
  TypeParam a(team, {}), b(team, {});
  std::vector<double> x = paper::start();
  for (int k = 0; k < 50; ++k) {
    const auto u = a.step(0.01 * k, x);
    const auto expected = b.solve(0.01 * k, x).u;
    expect_same_bits({u.begin(), u.end()}, {expected.begin(), expected.end()});
    advance(team, x, u, 0.01);
  }
}

TYPED_TEST(AnySolver, SeveralInOneLoopDoNotDisturbEachOther) {
  TypeParam alone(paper::team(Variant::joint), {}), a(paper::team(Variant::joint), {}),
      b(paper::target_alone(), {});
  const auto expected = inputs_of(alone, paper::start(), 100);
  std::vector<double> all;
  const std::vector<double> elsewhere = {1, 2, 3, 0, 1, 0, 0};
  fly(a, paper::start(), 100, [&](double t, const std::vector<double>&, const Solution& s) {
    b.solve(t, elsewhere);
    all.insert(all.end(), s.u.begin(), s.u.end());
  });
  expect_same_bits(all, expected);
}

TYPED_TEST(AnySolver, AfterARestartItFliesItsFirstFlightAgainBitForBit) {
  TypeParam solver(paper::team(Variant::masked), {});
  const auto first = inputs_of(solver, paper::saturating_start(), 200);
  solver.restart();
  expect_same_bits(inputs_of(solver, paper::saturating_start(), 200), first);
}

TYPED_TEST(AnySolver, PredictsTheSameHoweverOftenItIsLookedAtAndNothingWhereItMadeNoPlan) {
  TypeParam solver(paper::team(Variant::masked), {});
  const Solution planned = solver.solve(0.0, paper::start());
  const std::vector<double> once(planned.x.begin(), planned.x.end());
  ASSERT_FALSE(once.empty());
  expect_same_bits({planned.x.begin(), planned.x.end()}, once);
  EXPECT_EQ(solver.solve(0.01, std::vector<double>(14, not_a_number)).x.size(), 0u);
}

TYPED_TEST(AnySolver, AfterARestartNothingIsLeftOfTheOldPlan) {
  const Team team = paper::team(Variant::masked);
  TypeParam solver(team, {}), fresh(team, {});
  const std::vector<double> bad(14, not_a_number), x = paper::saturating_start();
  fly(solver, x, 100);
  (void)solver.solve(1.0, bad);  // refused: the old plan would go on
  solver.restart();
  for (const auto& state : {bad, x, bad}) {
    const Solution again = solver.solve(0.0, state), first = fresh.solve(0.0, state);
    expect_same_bits({again.u.begin(), again.u.end()}, {first.u.begin(), first.u.end()});
    expect_same_bits({again.x.begin(), again.x.end()}, {first.x.begin(), first.x.end()});
  }
}

TYPED_TEST(AnySolver, HeadingsOfAnyLengthMeanTheSame) {
  TypeParam unit(paper::team(Variant::joint), {}), scaled(paper::team(Variant::joint), {});
  std::vector<double> x = paper::start(), y = x;
  y[3] = 4.0, y[10] = 0.25;
  const auto a = unit.solve(0.0, x).u, b = scaled.solve(0.0, y).u;
  expect_same_bits({a.begin(), a.end()}, {b.begin(), b.end()});
}

TYPED_TEST(AnySolver, AStateThatIsNoStateIsRefusedAndTheLastPlanFliesOn) {
  const Team team = paper::team(Variant::masked);
  std::vector<std::vector<double>> refused;
  for (const double bad : {not_a_number, infinite, -infinite}) {
    for (std::size_t i = 0; i < 14; ++i) {
      refused.push_back(paper::start());
      refused.back()[i] = bad;
    }
  }
  refused.push_back(paper::start());
  refused.back()[3] = refused.back()[4] = 0.0;  // no heading
  for (const std::size_t size : std::initializer_list<std::size_t>{0, 1, 7, 13, 15, 1000})
    refused.emplace_back(size, 0.5);

  TypeParam solver(team, {});
  for (const auto& bad : refused) {
    solver.restart();
    std::vector<double> x = fly(solver, paper::start(), 150);
    const auto last = solver.solve(1.5, x).u;
    const std::vector<double> before(last.begin(), last.end());
    const Solution s = solver.solve(1.51, bad);
    EXPECT_EQ(s.status, Status::invalid_state);
    expect_usable(team, 1.51, s.u, "refused");
    // A period on, the plan of before is the input still.
    for (std::size_t j = 0; j < before.size(); ++j) EXPECT_NEAR(s.u[j], before[j], 0.05);
    const Solution next = solver.solve(1.52, x);
    EXPECT_NE(next.status, Status::invalid_state);
    expect_usable(team, 1.52, next.u, "after it");
  }
}

TYPED_TEST(AnySolver, RefusedFromTheFirstItGivesInputsWithinLimits) {
  for (const auto& limits : {std::pair{-1.0, 1.0}, std::pair{0.2, 0.8}, std::pair{-0.9, -0.1}}) {
    const Team team = paper::team(Variant::masked, limits);
    TypeParam solver(team, {});
    for (int k = 0; k < 5; ++k) {
      const Solution s = solver.solve(0.01 * k, std::vector<double>(14, not_a_number));
      EXPECT_EQ(s.status, Status::invalid_state);
      expect_usable(team, 0.01 * k, s.u, "first");
    }
  }
}

TYPED_TEST(AnySolver, APlanIsFlownStageByStageWhileStatesAreMissing) {
  const Team team = paper::team(Variant::masked);
  TypeParam solver(team, {});
  const auto x = fly(solver, paper::saturating_start(), 100);
  for (int k = 100; k < 400; ++k) {
    const Solution s = solver.solve(0.01 * k, {});
    EXPECT_EQ(s.status, Status::invalid_state);
    expect_usable(team, 0.01 * k, s.u, "blind");
  }
  fly(
      solver, x, 200,
      [&](double t, const std::vector<double>&, const Solution& s) {
        expect_usable(team, t, s.u, "again");
        EXPECT_TRUE(gives_plan(s.status));
      },
      4.0);
}

TYPED_TEST(AnySolver, WhatIsPlannedIsWhatFliesWhenStatesAreMissing) {
  TypeParam solver(paper::team(Variant::masked), {});
  std::vector<double> planned(8, not_a_number);
  solver.planned(0.0, planned);
  EXPECT_EQ(planned, std::vector<double>(8, 0.0)) << "before there is a plan";
  std::vector<double> x = fly(solver, paper::saturating_start(), 100);
  const auto now = solver.solve(1.0, x).u;
  const std::vector<double> first(now.begin(), now.end());
  solver.planned(1.0, planned);
  expect_same_bits(planned, first);
  for (int k = 100; k < 300; ++k) {
    solver.planned(0.01 * k, planned);
    const auto flown = solver.solve(0.01 * k, {}).u;
    expect_same_bits(planned, {flown.begin(), flown.end()});
  }
  solver.restart();
  solver.planned(1.0, planned);
  EXPECT_EQ(planned, std::vector<double>(8, 0.0)) << "forgotten with the iterate";
}

TYPED_TEST(AnySolver, ATimeThatIsNoTimeIsRefused) {
  const Team team = paper::team(Variant::joint);
  TypeParam solver(team, {});
  for (const double t : {not_a_number, infinite, -infinite}) {
    const Solution s = solver.solve(t, paper::start());
    EXPECT_EQ(s.status, Status::invalid_state);
    expect_usable(team, 0.0, s.u, "no time");
    fly(solver, paper::start(), 20);
  }
}

TYPED_TEST(AnySolver, TimeMayStandJumpOrGoBack) {
  const Team team = paper::team(Variant::masked);
  Random random(1);
  TypeParam solver(team, {});
  std::vector<double> x = paper::start();
  double t = 0.0;
  for (int k = 0; k < 400; ++k) {
    const Solution s = solver.solve(t, x);
    expect_usable(team, t, s.u, "time");
    EXPECT_NE(s.status, Status::invalid_state);
    advance(team, x, s.u, 0.01);
    const double jumps[] = {0.01, 0.01, 0.01, 0.0, 0.5, -0.3, 1e-7, 1e4};
    t += jumps[random() % 8];
  }
}

TYPED_TEST(AnySolver, HardPlacesGiveUsableInputs) {
  const Team team = paper::team(Variant::joint);
  std::vector<std::vector<double>> places;
  const auto place = [&](Vec3<double> observer, Vec2<double> d, Vec3<double> target) {
    places.push_back(
        {observer.x, observer.y, observer.z, d.x, d.y, 0, 0, target.x, target.y, target.z, 1, 0, 0, 0});
  };
  place({0, 0, 1}, {1, 0}, {0, 0, 1});          // one in the other
  place({0, 0, 1}, {1, 0}, {-1.5, 0, 1});       // behind the sensor
  place({0, 0, 1}, {1, 0}, {-1.5, 1e-300, 1});  // and a subnormal beside it
  place({1000, 0, 1}, {0, 1}, {0, 0, 1});       // out of sight
  place({0.17, 0, 1}, {-1, 0}, {0, 0, 1});      // at the sensor itself
  place({1e8, -1e8, 1e8}, {0.6, 0.8}, {0, 0, 0});
  for (const auto& start : places) {
    TypeParam solver(team, {});
    fly(solver, start, 300, [&](double t, const std::vector<double>&, const Solution& s) {
      expect_usable(team, t, s.u, "hard place");
    });
  }
}

TYPED_TEST(AnySolver, StatesOfAnySizeGiveUsableInputsAndNoLastingHarm) {
  const Team team = paper::team(Variant::masked);
  TypeParam solver(team, {});
  for (const double size : {1e10, 1e80, 1e150, 1e160, 1e300}) {
    std::vector<double> x = paper::start();
    x[0] = size, x[8] = -size;
    for (int k = 0; k < 20; ++k) expect_usable(team, 0.01 * k, solver.solve(0.01 * k, x).u, "huge");
    fly(
        solver, paper::start(), 100,
        [&](double t, const std::vector<double>&, const Solution& s) {
          expect_usable(team, t, s.u, "after it");
          EXPECT_TRUE(gives_plan(s.status)) << to_string(s.status);
        },
        1.0);
  }
}

TYPED_TEST(AnySolver, RandomTeamsOfAnySizeGetUsableInputs) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const int agents = seed % 4 == 0 ? 8 : 1 + static_cast<int>(seed % 4);
    const Team team = random_team(random, agents, Feeling::anyone);
    TypeParam solver(team, {.N = 10});
    fly(solver, random_states(random, team, 2.0), 100,
        [&](double t, const std::vector<double>&, const Solution& s) {
          expect_usable(team, t, s.u, "random team");
        });
  }
}

TYPED_TEST(AnySolver, LimitsThatChangeAreKeptFromTheirTimeOn) {
  Team team;
  for (const char* name : {"uav0", "uav1"}) {
    team.add(Agent{.name = name,
                   .model = Multirotor{},
                   .Q = {1.5, 1.5, 1.6, 1, 1, 0, 0},
                   .R = std::vector<double>(4, 0.1),
                   .Q_f = {},
                   .x_ref = paper::target_path(),
                   .limits = InputLimits(
                       {0.0, 0.5, 1.0, 1.5},
                       {{-1, -1, -1, -1}, {-0.2, -0.3, -1, -0.1}, {0.1, 0.1, -0.1, 0.1}, {-1, -1, -1, -1}},
                       {{1, 1, 1, 1}, {0.2, 0.1, 0.1, 0.5}, {0.3, 0.2, 0.1, 0.2}, {1, 1, 1, 1}})});
  }
  TypeParam solver(team, {});
  fly(solver, paper::saturating_start(), 300, [&](double t, const std::vector<double>&, const Solution& s) {
    expect_usable(team, t, s.u, "limits");
    EXPECT_TRUE(gives_plan(s.status)) << to_string(s.status);
  });
}

TYPED_TEST(AnySolver, ObstaclesAreSeenAndNotSteered) {
  Team team;
  const AgentId uav0 = team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 0.5, 0.5}});
  const BodyId tree = team.add(Obstacle{.name = "tree"});
  team.couple(2.0 * KeepOut{.d_min = 0.8}, Between{uav0, tree});
  const auto nearest = [&](double y) {
    TypeParam solver(team, {});
    double least = 1e9;
    fly(solver, {3, 0.05, 0, 1, 0, 0, 0, /**/ 1.2, y, 0, 0, 0, 0}, 800,
        [&](double t, const std::vector<double>& x, const Solution& s) {
          expect_usable(team, t, s.u, "obstacle");
          least = std::min(least, std::hypot(x[0] - 1.2, x[1]));
        });
    return least;
  };
  EXPECT_GT(nearest(0.0), 0.5) << "the tree stands in the way";
  EXPECT_LT(nearest(50.0), 0.1) << "the tree is far off";
}

/// Not a number beyond x = 3 m.
struct Brink {
  static constexpr std::string_view name = "brink";

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return square(a.p.z - b.p.z) * sqrt(S(3.0) - a.p.x);
  }
};

Team at_the_brink() {
  Team team;
  const AgentId a = team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 1, 1}, .name = "a"});
  const AgentId b = team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 1, 1}, .name = "b"});
  team.couple(1.0 * Brink{}, Between{a, b});
  return team;
}

TYPED_TEST(AnySolver, AResidualThatIsNotKnownIsInfinite) {
  const std::vector<double> x = {0, 0, 1, 1, 0, 0, 0, 1, 0, 1.2, 1, 0, 0, 0};
  std::vector<double> beyond = x;
  beyond[0] = 4.0;
  TypeParam solver(at_the_brink(), {});
  fly(solver, x, 20);
  EXPECT_TRUE(std::isfinite(solver.kkt(0.2, x)));
  EXPECT_EQ(solver.kkt(0.2, beyond), infinite) << "a potential that is no number";
  for (const double t : {not_a_number, infinite, -infinite}) EXPECT_EQ(solver.kkt(t, x), infinite) << t;
  EXPECT_EQ(solver.kkt(0.2, std::vector<double>(14, not_a_number)), infinite);
  EXPECT_EQ(solver.kkt(0.2, {}), infinite);
  EXPECT_EQ(solver.solve(0.2, std::vector<double>(14, not_a_number)).residual, infinite);
  EXPECT_EQ(solver.solve(0.21, {}).residual, infinite);
  EXPECT_EQ(solver.solve(not_a_number, x).residual, infinite);
  int lost = 0;  // a trajectory of unknowns takes some updates to get there
  for (int k = 22; k < 72; ++k) {
    const Solution s = solver.solve(0.01 * k, beyond);
    EXPECT_EQ(s.status == Status::not_finite, s.residual == infinite);
    expect_usable(solver.ocp().team(), 0.01 * k, s.u, "beyond the brink");
    lost += s.residual == infinite ? 1 : 0;
  }
  EXPECT_GE(lost, 3);
  (void)solver.solve(0.72, x);
  EXPECT_TRUE(std::isfinite(solver.solve(0.73, x).residual));
}

TYPED_TEST(AnySolver, AReferenceThatThrowsOrChangesItsLengthIsAStatusNotACrash) {
  enum class Fault { throws, shrinks, grows };
  for (const Fault fault : {Fault::throws, Fault::shrinks, Fault::grows}) {
    const auto reference = [fault](double t) {
      const bool now = t > 1.15 && t < 1.3;  // 1 s ahead of the update
      if (now && fault == Fault::throws) throw std::runtime_error("no way to be found");
      return std::vector<double>(now ? (fault == Fault::grows ? 900 : 3) : 7, 0.5);
    };
    Team team;
    team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 0, 0}, .Q_f = {1, 1, 1, 0, 0, 0, 0}, .x_ref = reference});
    TypeParam solver(team, {});
    int failed = 0;
    Status last = Status::converged;
    fly(solver, {0, 0, 1, 1, 0, 0, 0}, 200, [&](double t, const std::vector<double>&, const Solution& s) {
      expect_usable(team, t, s.u, "a reference that fails");
      failed += s.status == Status::not_finite ? 1 : 0;
      last = s.status;
    });
    EXPECT_GT(failed, 5);
    EXPECT_TRUE(gives_plan(last)) << "it is a reference again";
  }
}

TYPED_TEST(AnySolver, InputsThatHaveNoRoomAreNotWritten) {
  TypeParam solver(paper::team(Variant::masked), {});
  fly(solver, paper::saturating_start(), 30);
  for (const std::size_t room : {0U, 1U, 7U, 9U}) {
    std::vector<double> u(room, 7.0);
    solver.planned(0.3, u);
    EXPECT_EQ(u, std::vector<double>(room, 7.0));
  }
}

/// x is where it was linearised: from the measured state, under the inputs that were planned before
/// the step.
template <class S>
void expect_prediction_before_the_step() {
  const Team team = paper::team(Variant::masked);
  const Horizon horizon{.T = 1.0, .N = 12, .dt = 0.01};
  S solver(team, horizon);
  std::vector<double> x = fly(solver, paper::saturating_start(), 300);
  // The horizon of a continuation has all but its length by now.
  advance(team, x, solver.solve(3.0, x).u, 0.01);
  std::vector<double> planned(8 * 12), rate(14), state = x;
  for (std::size_t k = 0; k < 12; ++k)
    solver.planned(3.0 + (static_cast<double>(k) + 0.5) * horizon.h(), std::span(planned).subspan(8 * k, 8));
  const Solution s = solver.solve(3.01, x);
  for (std::size_t k = 0; k <= 12; ++k) {
    for (std::size_t i = 0; i < 14; ++i) ASSERT_NEAR(s.x[14 * k + i], state[i], 5e-3) << k << ", " << i;
    if (k == 12) break;
    for (const std::size_t body : {0U, 1U}) {
      const Model& model = team.model(BodyId{static_cast<int>(body)});
      model.f(&state[7 * body], &planned[8 * k + 4 * body], &rate[7 * body]);
    }
    for (std::size_t i = 0; i < 14; ++i) state[i] += horizon.h() * rate[i];
  }
}

TYPED_TEST(AnySolver, ThePredictionIsTheTrajectoryBeforeTheStep) {
  expect_prediction_before_the_step<TypeParam>();
}

}  // namespace
}  // namespace sightline
