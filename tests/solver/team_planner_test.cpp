#include <gtest/gtest.h>

#include "sightline/solver.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/gradient_planner.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// Robots of a team in pieces of two, or fewer.
Partition in_twos(const Team& team) {
  Partition partition;
  for (std::size_t i = 0; i < team.agents().size(); ++i) {
    if (i % 2 == 0) partition.emplace_back();
    partition.back().push_back(AgentId{team.find(team.agents()[i].name)});
  }
  return partition;
}

struct Newton {
  static std::unique_ptr<Solver> make(const Team& team, const Horizon& over = default_horizon) {
    return newton_riccati_of(over)(team);
  }
};
struct Partitioned {
  static std::unique_ptr<Solver> make(const Team& team, const Horizon& over = default_horizon) {
    return std::make_unique<PartitionedSolver>(team, in_twos(team), newton_riccati_of(over));
  }
};
struct Gradient {
  static std::unique_ptr<Solver> make(const Team& team, const Horizon& over = default_horizon) {
    return gradient_planner_of(over)(team);
  }
};

template <class Make>
class AnyTeamPlanner : public testing::Test {};
using Makes = testing::Types<Newton, Partitioned, Gradient>;
TYPED_TEST_SUITE(AnyTeamPlanner, Makes);

TYPED_TEST(AnyTeamPlanner, IsTheCapabilityOfASolverOfTheSameProblem) {
  const auto solver = TypeParam::make(chain(3, paper::Variant::masked));
  TeamPlanner& planner = team_planner_of(*solver, "a test");
  EXPECT_EQ(&planner, solver->team_planner());
  EXPECT_EQ(&planner.ocp(), &solver->ocp());
  EXPECT_GT(planner.tolerance(), 0.0);
  const Solution s = solver->solve(0.0, chain_start(3));
  EXPECT_EQ(s.status == Status::converged, s.residual <= planner.tolerance());
}

TYPED_TEST(AnyTeamPlanner, ThePlanThatWasSetIsThePlanAndWhatFitsNowhereChangesNothing) {
  const auto solver = TypeParam::make(chain(3, paper::Variant::masked));
  TeamPlanner& planner = *solver->team_planner();
  std::vector<double> u(12), wrong(11, 0.9);
  for (int k = 0; k < default_horizon.N; ++k) {
    for (std::size_t i = 0; i < u.size(); ++i) u[i] = 0.01 * k - 0.05 * static_cast<double>(i);
    planner.set_plan(k, u);
  }
  const std::vector<double> whole = planner.whole_plan();
  for (std::size_t i = 0; i < whole.size(); ++i)
    EXPECT_EQ(whole[i], 0.01 * static_cast<double>(i / 12) - 0.05 * static_cast<double>(i % 12));
  planner.set_plan(-1, u);
  planner.set_plan(default_horizon.N, u);
  planner.set_plan(0, wrong);
  planner.take_over(planner.ocp().team(), std::span(whole).first(whole.size() - 12));
  planner.set_prediction({.who = BodyId{0}});
  planner.set_prediction({.who = BodyId{9}});
  EXPECT_EQ(planner.whole_plan(), whole);
  for (const int k : {-1, default_horizon.N, 1 << 30}) planner.plan(k, u);
  EXPECT_EQ(u[1], 0.01 * (default_horizon.N - 1) - 0.05);
  planner.plan(0, wrong);
  EXPECT_EQ(wrong, std::vector<double>(11, 0.9));
}

TYPED_TEST(AnyTeamPlanner, APlanIsTakenOverByNameWhateverTheOrderAndOthersKeepTheirs) {
  const auto from = TypeParam::make(chain_of({0, 1, 2}, paper::Variant::joint)),
             to = TypeParam::make(chain_of({2, 0, 3, 1}, paper::Variant::joint));
  (void)from->solve(0.0, chain_start(3));
  TeamPlanner &before = *from->team_planner(), &after = *to->team_planner();
  std::vector<double> u(12), v(16, 0.125);
  for (int k = 0; k < default_horizon.N; ++k) after.set_plan(k, v);
  after.take_over(from->ocp().team(), before.whole_plan());
  for (int k = 0; k < default_horizon.N; ++k) {
    before.plan(k, u);
    after.plan(k, v);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(v[i], u[8 + i]);
      EXPECT_EQ(v[4 + i], u[i]);
      EXPECT_EQ(v[8 + i], 0.125) << "the one that is new";
      EXPECT_EQ(v[12 + i], u[4 + i]);
    }
  }
}

TYPED_TEST(AnyTeamPlanner, ItsPlanIsWhereTheNextUpdateOfAnotherBegins) {
  const Team team = chain(3, paper::Variant::joint);
  const auto from = TypeParam::make(team), to = TypeParam::make(team);
  const std::vector<double> x = fly(*from, chain_start(3), 200);
  to->team_planner()->take_over(team, from->team_planner()->whole_plan());
  EXPECT_EQ(to->kkt(2.0, x), from->kkt(2.0, x));
}

/// Cost of 3 s of flight from the chain's start.
double cost_of(Solver& solver) {
  double cost = 0.0;
  fly(solver, chain_start(4), 300, [&](double t, const std::vector<double>& x, const Solution& s) {
    EXPECT_TRUE(gives_plan(s.status)) << t;
    cost += default_horizon.dt * stage_cost(solver.ocp().team(), t, x, s.u);
  });
  return cost;
}

TEST(TeamPlanner, ASolverOfOnesOwnPlansInPartsWithinOnePercentOfTheCostOfTheWhole) {
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    const Team team = chain(4, variant);
    GradientPlanner whole(team, default_horizon);
    PartitionedSolver parts(team, in_twos(team), gradient_planner_of(default_horizon));
    const double best = cost_of(whole);
    EXPECT_NEAR(cost_of(parts), best, 0.01 * best);
  }
}

TEST(TeamPlanner, ASolverWithoutTheCapabilityIsRefusedWithItsNameAndTheNeed) {
  const Team team = chain(2, paper::Variant::masked);
  Cgmres cgmres(team, default_horizon);
  Cmscgmres cmscgmres(team, default_horizon);
  EXPECT_EQ(cgmres.team_planner(), nullptr);
  EXPECT_EQ(refusal_of([&] { (void)team_planner_of(cgmres, "a test"); }),
            "the solver cgmres cannot hand over its plan, which a test needs, expected one that can, such as "
            "newton_riccati");
  EXPECT_EQ(
      refusal_of([&] {
        PartitionedSolver(team, in_twos(team), [](const Team& part) {
          return std::make_unique<Cmscgmres>(part, default_horizon);
        });
      }),
      "the solver cmscgmres cannot hand over its plan, which a team that plans in parts needs, expected one "
      "that can, such as newton_riccati");
}

TEST(TeamPlanner, APartitionedOneUsesWhatIsPredictedOfBodiesAndForgetsIt) {
  Team team = chain(3, paper::Variant::joint);
  const BodyId ball = team.add(Obstacle{.name = "ball"});
  team.couple(1.0 * KeepOut{}, Between{team.find("uav0"), ball});
  std::vector<double> x = chain_start(3);
  x.insert(x.end(), {0.2, 0.4, 1.0, 0.0, 0.0, 0.0});
  Prediction coming{.who = ball, .time = 0.0, .h = default_horizon.h()};
  for (int k = 0; k <= default_horizon.N; ++k)
    coming.sights.push_back({{{0.2, 0.4 - 0.05 * k, 1.0}, {1, 0}}, {0, -1, 0}});
  const auto inputs_after = [&](std::initializer_list<Prediction> predictions) {
    const auto solver = Partitioned::make(team);
    for (const Prediction& prediction : predictions) solver->team_planner()->set_prediction(prediction);
    const Solution s = solver->solve(0.0, x);
    return std::vector<double>(s.u.begin(), s.u.end());
  };
  const Prediction none{.who = ball, .time = 0.0, .h = default_horizon.h()};
  Prediction of_robot = coming;
  of_robot.who = team.find("uav2");
  EXPECT_NE(inputs_after({coming}), inputs_after({}));
  EXPECT_EQ(inputs_after({coming, none}), inputs_after({}));
  EXPECT_EQ(inputs_after({of_robot}), inputs_after({})) << "robots of the team are planned, not predicted";
}

}  // namespace
}  // namespace sightline
