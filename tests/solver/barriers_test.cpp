// Limits beyond boxes, docs/equations.md, 12: the laws of all solvers for a robot with a barrier.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "bench/ipopt.hpp"
#include "cli/allocations.hpp"
#include "sightline/kernels.hpp"
#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/error.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

using paper::Variant;

/// A user's own, over state and input: slow where it turns.
struct SlowTurn {
  int states() const { return 7; }
  int inputs() const { return 4; }

  template <class S>
  S operator()(std::span<const S> x, std::span<const S> u) const {
    return square(x[5]) + square(x[6]) + 0.5 * square(u[3]) - 0.6;
  }
};

/// A robot that is sent two metres off and may be in a hurry.
Team hasty() {
  Team team;
  team.add(Multirotor{}, {.Q = {4, 4, 4, 1, 1, 0, 0},
                          .R = {0.1, 0.1, 0.1, 0.1},
                          .Q_f = {2, 2, 2, 0, 0, 0, 0},
                          .x_ref = std::vector<double>{1.5, -1.4, 1, 0, 1, 0, 0}});
  return team;
}
const std::vector<double> at_rest = {0, 0, 1, 1, 0, 0, 0};

/// The largest c along a flight, from `settle` updates on.
double worst_of(Solver& solver, const Limit& limit, const std::vector<double>& start, int settle = 0) {
  const Team& team = solver.ocp().team();
  double worst = -1.0;
  int k = 0;
  fly(solver, start, 500, [&](double, const std::vector<double>& x, const Solution& s) {
    EXPECT_TRUE(gives_plan(s.status)) << to_string(s.status);
    if (k++ < settle) return;
    worst = std::max(worst, limit(team.model(paper::uav0).sight(x.data(), s.u.data()), x, s.u));
  });
  return worst;
}

template <class S>
class AnySolverWithBarriers : public testing::Test {};

using SolversWithBarriers = testing::Types<Cgmres, Cmscgmres, NewtonRiccati>;
TYPED_TEST_SUITE(AnySolverWithBarriers, SolversWithBarriers);

TYPED_TEST(AnySolverWithBarriers, ALimitIsKeptThatIsBrokenWithoutIt) {
  for (const Limit& limit :
       {Limit(SpeedLimit{.max = 0.5}), Limit(InputDisc{.radius = 0.6}), Limit(SlowTurn{})}) {
    Team free = hasty(), limited = hasty();
    limited.constrain(RelaxedBarrier{.limit = limit, .mu = 0.05, .delta = 0.02}, paper::uav0);
    TypeParam without(free, {}), with(limited, {});
    EXPECT_GT(worst_of(without, limit, at_rest), 0.2) << limit.name();
    EXPECT_LE(worst_of(with, limit, at_rest), 0.03) << limit.name();
  }
}

TYPED_TEST(AnySolverWithBarriers, FromFarBeyondALimitItComesBackAndStays) {
  Team team = hasty();
  const SpeedLimit limit{.max = 0.5};
  team.constrain(RelaxedBarrier{.limit = limit, .mu = 0.05, .delta = 0.02}, paper::uav0);
  TypeParam solver(team, {});
  std::vector<double> fast = at_rest;
  fast[5] = 1.5, fast[6] = -1.0;
  EXPECT_GT(limit(team.model(paper::uav0).sight(fast.data(), std::vector<double>(4).data())), 10.0);
  EXPECT_LE(worst_of(solver, limit, fast, 200), 0.02);
}

TYPED_TEST(AnySolverWithBarriers, AWideLimitChangesNextToNothing) {
  Team free = hasty(), limited = hasty();
  limited.constrain(RelaxedBarrier{.limit = SpeedLimit{.max = 100}, .mu = 0.01, .delta = 0.1}, paper::uav0);
  TypeParam without(free, {}), with(limited, {});
  fly(without, at_rest, 200, [&](double t, const std::vector<double>& x, const Solution& s) {
    const auto u = with.solve(t, x).u;
    // Rounding alone, a weight that differs by 1e-15, moves the inputs of the solvers by
    // continuation by 1e-4.
    for (std::size_t j = 0; j < 4; ++j) EXPECT_NEAR(u[j], s.u[j], 5e-4) << t;
  });
}

TYPED_TEST(AnySolverWithBarriers, NoUpdateTakesMemory) {
  Team team = hasty();
  team.constrain(RelaxedBarrier{SpeedLimit{.max = 0.5}}, paper::uav0);
  team.constrain(RelaxedBarrier{SlowTurn{}}, paper::uav0);
  TypeParam solver(team, {});
  std::vector<double> x = at_rest;
  x[5] = 1.5, x[6] = -1.0;
  for (int k = 0; k < 100; ++k) {
    const std::int64_t before = cli::allocations();
    const auto u = solver.solve(0.01 * k, x).u;
    EXPECT_EQ(cli::allocations(), before) << k;
    advance(team, x, u, 0.01);
  }
}

/// Robots of one model, each with a limit of its own but the last; the same robots alone.
struct Four {
  Team together;
  std::vector<Team> alone;

  Four() {
    const std::vector<RelaxedBarrier> barriers = {
        {SpeedLimit{.max = 0.5}}, {SpeedLimit{.max = 0.7}}, {SlowTurn{}}};
    for (std::size_t i = 0; i <= barriers.size(); ++i) {
      alone.push_back(hasty());
      Agent agent = alone[i].agents()[0];
      agent.name.clear();
      const AgentId id = together.add(agent);
      if (i == barriers.size()) continue;
      alone[i].constrain(barriers[i], paper::uav0);
      together.constrain(barriers[i], id);
    }
  }
};

TEST(Barriers, InATeamEachRobotIsSteeredByItsOwnLimit) {
  const Four four;
  NewtonRiccati solver(four.together, {});
  std::vector<std::unique_ptr<NewtonRiccati>> alone;
  std::vector<double> start;
  for (const Team& team : four.alone) {
    alone.push_back(std::make_unique<NewtonRiccati>(team, Horizon{}));
    start.insert(start.end(), at_rest.begin(), at_rest.end());
  }
  fly(solver, start, 200, [&](double t, const std::vector<double>& x, const Solution& s) {
    for (std::size_t i = 0; i < alone.size(); ++i) {
      const auto u = alone[i]->solve(t, std::span(x).subspan(7 * i, 7)).u;
      if (t < 1.5) continue;  // where steps are searched along, a team is searched along together
      for (std::size_t j = 0; j < 4; ++j) EXPECT_NEAR(s.u[4 * i + j], u[j], 1e-3) << t << " s, robot " << i;
    }
  });
}

/// H_u of all stages, and its change along du, at the inputs u from the state x.
std::vector<double> slopes(const Ocp& ocp, const std::vector<double>& x, const std::vector<double>& u,
                           const std::vector<double>& du) {
  Hamiltonian hamiltonian(ocp);
  const auto states = static_cast<std::size_t>((ocp.horizon().N + 1) * ocp.nx());
  std::vector<double> X(states), Lambda(states), F(u.size()), dF(u.size());
  hamiltonian.set_time(0.0, ocp.horizon().h());
  hamiltonian.roll_out(x.data(), u.data(), ocp.nu(), nullptr, 0.0, X.data());
  hamiltonian.linearise(X.data(), u.data(), ocp.nu());
  hamiltonian.costates(X.data(), nullptr, 0.0, Lambda.data(), F.data(), ocp.nu());
  hamiltonian.second_order(Lambda.data());
  hamiltonian.tangent(du.data(), dF.data(), ocp.nu());
  F.insert(F.end(), dF.begin(), dF.end());
  return F;
}

TEST(Barriers, InATeamEachRobotFeelsItsOwnLimit) {
  const Four four;
  const Horizon horizon{.T = 1.0, .N = 8};
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const auto x = random_states(random, four.together, 1.0), u = random_numbers(random, 8 * 16, 1.0),
               du = random_numbers(random, 8 * 16, 1.0);
    const auto all = slopes(Ocp(four.together, horizon), x, u, du);
    for (std::size_t i = 0; i < four.alone.size(); ++i) {
      std::vector<double> own, d_own;
      for (std::size_t k = 0; k < 8; ++k) {
        for (std::size_t j = 0; j < 4; ++j)
          own.push_back(u[16 * k + 4 * i + j]), d_own.push_back(du[16 * k + 4 * i + j]);
      }
      const std::vector<double> x_own(&x[7 * i], &x[7 * i] + 7);
      const auto expected = slopes(Ocp(four.alone[i], horizon), x_own, own, d_own);
      for (std::size_t k = 0; k < 16; ++k) {  // stages of H_u, then of its change
        for (std::size_t j = 0; j < 4; ++j)
          EXPECT_LE(relative_error(all[16 * k + 4 * i + j], expected[4 * k + j]), 1e-12);
      }
    }
  }
}

TEST(Barriers, TheStageCostOfATeamHoldsThem) {
  Random random(1);
  const Team free = hasty();
  for (int k = 0; k < 200; ++k) {
    Team team = free;
    const RelaxedBarrier a{.limit = SlowTurn{}, .mu = 0.3, .delta = 0.2}, b{.limit = InputDisc{}};
    team.constrain(a, paper::uav0), team.constrain(b, paper::uav0);
    const auto x = random_states(random, team, 2.0), u = random_numbers(random, 4, 1.0);
    const std::span<const double> at_x(x), at_u(u);
    const Sight<double> sight = team.model(paper::uav0).sight(x.data(), u.data());
    EXPECT_NEAR(stage_cost(team, 0, x, u) - stage_cost(free, 0, x, u),
                a(sight, at_x, at_u) + b(sight, at_x, at_u), 1e-12);
  }
}

TEST(Barriers, NewtonRiccatiAgreesWithIpoptWhereLimitsAreActive) {
  Random random(2);
  const Horizon horizon{.T = 1.0, .N = 10};
  int active = 0;
  for (int trial = 0; trial < 12; ++trial) {
    Team team = paper::team(Variant::joint);
    for (const AgentId agent : {paper::uav0, paper::uav1}) {
      const double width = uniform(random, 0.05, 0.2);
      team.constrain(RelaxedBarrier{SpeedLimit{uniform(random, 0.3, 0.8)}, 0.01, width}, agent);
      team.constrain(RelaxedBarrier{InputDisc{uniform(random, 0.3, 0.8)}, 0.01, width}, agent);
    }
    const Ocp ocp(team, horizon);
    NewtonRiccati solver(ocp,
                         {.max_newton_steps = 50, .tolerance = 1e-9, .max_krylov = 30, .krylov_stop = 1e-12});
    const auto x = random_states(random, team, 1.5);
    for (int i = 0; i < 3; ++i) solver.solve(0.2, x);
    EXPECT_LE(solver.kkt(0.2, x), 1e-8);
    std::vector<double> u(static_cast<std::size_t>(horizon.N * 8));
    for (int k = 0; k < horizon.N; ++k)
      solver.plan(k, std::span(u).subspan(8 * static_cast<std::size_t>(k), 8));
    const Optimum optimum = IpoptReference(ocp).solve(0.2, x, u);
    for (std::size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(u[i], optimum.u[i], 1e-6) << trial;
    active += std::hypot(u[0], u[1]) > 0.25 || std::hypot(u[4], u[5]) > 0.25;
  }
  EXPECT_GE(active, 4);
}

TEST(Barriers, CompiledAndInterpretedFlyTheSameBits) {
  for (const Limit& limit : {Limit(SpeedLimit{.max = 0.5}), Limit(InputDisc{.radius = 0.6})}) {
    Team team = hasty();
    team.constrain(RelaxedBarrier{.limit = limit, .mu = 0.03, .delta = 0.07}, paper::uav0);
    NewtonRiccati compiled(team, {}), interpreted(team, {}, {.kernels = KernelChoice::interpreted});
    fly(compiled, at_rest, 100, [&](double t, const std::vector<double>& x, const Solution& s) {
      const auto u = interpreted.solve(t, x).u;
      for (std::size_t j = 0; j < 4; ++j) EXPECT_TRUE(same_bits(s.u[j], u[j]));
    });
  }
}

}  // namespace
}  // namespace sightline
