// The cost of the inputs' rates, du/dt' diag(R_rate) du/dt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using Values = std::vector<double>;
using testing::HasSubstr;

/// A robot that goes to a place 1 m off and looks at a body on its way.
template <RobotModel M>
Team looker(const M& robot, const Values& R_rate) {
  Team team;
  AgentOptions<M> options;
  options.Q[0] = options.Q[1] = options.Q[2] = 2.0;
  options.x_ref = Reference(Constant{.p = {1.0, -0.4, 1.3}});
  options.R_rate = R_rate;
  options.name = "uav";
  const AgentId uav = team.add(robot, options);
  const BodyId seen = team.add(Obstacle{.name = "tree"});
  team.couple(2.0 * Bearing{}, {uav, seen}, {uav});
  team.constrain(RelaxedBarrier{SpeedLimit{}}, uav);
  return team;
}

/// Of the plan of one robot and an obstacle from x on: stage costs times h, and those of the rates.
double cost_of(const Team& team, const Horizon& horizon, Values x, const std::vector<Values>& u,
               const Values& before) {
  const double h = horizon.h();
  const Values& R = team.agents()[0].R_rate;
  double cost = 0.0;
  Values rate(x.size());
  for (std::size_t k = 0; k < u.size(); ++k) {
    cost += h * stage_cost(team, static_cast<double>(k) * h, x, u[k]);
    for (std::size_t i = 0; i < u[k].size(); ++i) {
      const double step = k > 0 ? h : horizon.dt, by = (u[k][i] - (k > 0 ? u[k - 1] : before)[i]) / step;
      cost += step * R[i] * by * by;
    }
    for (int b = 0; b < team.bodies(); ++b) {
      const int at = team.state_offset(BodyId{b});
      team.model(BodyId{b}).f(&x[static_cast<std::size_t>(at)], u[k].data(),
                              &rate[static_cast<std::size_t>(at)]);
    }
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += h * rate[i];
  }
  return cost;
}

template <RobotModel M>
void expect_stationary(const M& robot) {
  const Values R_rate = {0.02, 0.05, 0.0, 0.1}, before = {0.1, -0.05, 0.02, 0.1};
  const Team team = looker(robot, R_rate);
  NewtonRiccati solver(team, default_horizon, {.max_newton_steps = 200, .tolerance = 1e-9, .max_krylov = 20});
  Values x(static_cast<std::size_t>(team.nx()));
  team.model(BodyId{0}).at_rest({{0.2, 0, 1}, {0.8, 0.6}}, x.data());
  x[x.size() - 6] = 3.0, x[x.size() - 5] = 0.5, x[x.size() - 4] = 1.0, x[x.size() - 2] = 0.1;
  solver.set_applied({before, Values(4)});
  const Solution solution = solver.solve(0.0, x);
  EXPECT_EQ(solution.status, Status::converged);
  std::vector<Values> u(static_cast<std::size_t>(default_horizon.N), Values(4));
  for (std::size_t k = 0; k < u.size(); ++k) solver.plan(static_cast<int>(k), u[k]);
  EXPECT_EQ(Values(solution.u.begin(), solution.u.end()), u[0]);
  for (std::size_t k = 0; k < u.size(); ++k) {
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_LT(std::abs(u[k][i]), 0.999) << "no limit is active";
      constexpr double by = 1e-4;
      std::vector<Values> more = u, less = u;
      more[k][i] += by, less[k][i] -= by;
      const double slope = (cost_of(team, default_horizon, x, more, before) -
                            cost_of(team, default_horizon, x, less, before)) /
                           (2 * by);
      EXPECT_NEAR(slope, 0.0, 1e-7) << "stage " << k << ", input " << i;
    }
  }
  double moved = 0.0;
  for (const Values& of_stage : u) moved = std::max(moved, std::abs(of_stage[0] - u[0][0]));
  EXPECT_GT(moved, 0.05);
}

TEST(RateCost, APlanIsStationaryInTheWholeCostFromTheInputThatWasApplied) {
  expect_stationary(Multirotor{});
  expect_stationary(LaggingHoverMultirotor{});
}

/// Inputs of a closed loop of 12 s, and where it ends.
struct RateFlight {
  std::vector<Values> u;
  Values x;
  double fastest(std::size_t i) const {
    double most = 0.0;
    for (std::size_t k = 1; k < u.size(); ++k) most = std::max(most, std::abs(u[k][i] - u[k - 1][i]) / 0.01);
    return most;
  }
};
RateFlight flown(Solver& solver, Values x) {
  RateFlight flight;
  flight.x = fly(solver, std::move(x), 1200, [&](double, const Values&, const Solution& s) {
    flight.u.emplace_back(s.u.begin(), s.u.end());
    for (const double u : s.u) ASSERT_LE(std::abs(u), 1.0);
  });
  return flight;
}
const Values from_afar = {-1, 0.5, 1, 1, 0, 0, 0, /**/ 3, 0.5, 1, 0, 0, 0};

TEST(RateCost, SlowsTheInputThatHasItAndTheRobotArrivesAllTheSame) {
  NewtonRiccati free(looker(Multirotor{}, {}), default_horizon),
      next_to_nothing(looker(Multirotor{}, Values(4, 1e-12)), default_horizon),
      slow(looker(Multirotor{}, {0.3, 0.3, 0.0, 0.0}), default_horizon),
      slower(looker(Multirotor{}, {3.0, 3.0, 0.0, 0.0}), default_horizon);
  const RateFlight a = flown(free, from_afar), same = flown(next_to_nothing, from_afar),
                   b = flown(slow, from_afar), c = flown(slower, from_afar);
  for (std::size_t k = 0; k < a.u.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i) ASSERT_NEAR(a.u[k][i], same.u[k][i], 1e-6);
  EXPECT_LT(b.fastest(0), 0.8 * a.fastest(0));
  EXPECT_LT(c.fastest(0), 0.5 * b.fastest(0));
  EXPECT_NEAR(b.x[0], a.x[0], 0.05);
  EXPECT_NEAR(b.x[1], a.x[1], 0.05);
}

TEST(RateCost, CountsFromTheInputThatIsToldWithoutWhatIsAdded) {
  NewtonRiccati solver(looker(Multirotor{}, Values(4, 1e6)), default_horizon);
  const Values before = {0.5, -0.4, 0.3, 0.2}, added = {0.2, 0.1, -0.1, 0.0};
  solver.set_applied({before, added});
  const auto u = solver.step(0.0, from_afar);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(u[i], before[i] - added[i], 1e-4);
}

TEST(RateCost, HoldsTogetherWithTheLimitOfTheRateAndWithOtherRobotsWithout) {
  const auto team_of = [](const Values& rate_max, const Values& R_rate) {
    Team team;
    team.add(Multirotor{}, {.Q = {2, 2, 2, 0, 0, 0, 0},
                            .x_ref = Constant{.p = {1, 1, 2}},
                            .name = "a",
                            .rate_max = rate_max,
                            .R_rate = R_rate});
    team.add(Multirotor{}, {.Q = {2, 2, 2, 0, 0, 0, 0}, .x_ref = Constant{.p = {-1, 1, 2}}, .name = "b"});
    return team;
  };
  const auto loop = [](Solver& solver, double& fastest) {
    Values x = {0, 0, 1, 1, 0, 0, 0, /**/ 0, 3, 1, 1, 0, 0, 0}, before(8), all;
    for (int k = 0; k < 200; ++k) {
      solver.set_applied({before, Values(8)});
      const auto u = solver.step(0.01 * k, x);
      for (std::size_t i = 0; i < 4; ++i) fastest = std::max(fastest, std::abs(u[i] - before[i]) / 0.01);
      before.assign(u.begin(), u.end());
      all.insert(all.end(), u.begin(), u.end());
      advance(solver.ocp().team(), x, u, 0.01);
    }
    return all;
  };
  double fastest = 0.0, of_parts = 0.0, free = 0.0;
  const Team limited = team_of(Values(4, 2.0), Values(4, 0.01));
  NewtonRiccati whole(limited, default_horizon), none(team_of({}, {}), default_horizon);
  PartitionedSolver parts(limited, {{AgentId{{0}}}, {AgentId{{1}}}}, newton_riccati_of(default_horizon));
  const Values u = loop(whole, fastest), v = loop(parts, of_parts), w = loop(none, free);
  EXPECT_LE(fastest, 2.0 + 1e-9);
  EXPECT_GT(free, 10.0);
  for (std::size_t k = 0; k < u.size(); ++k) {
    EXPECT_NEAR(u[k], v[k], 1e-5);
    if (k % 8 >= 4) {
      EXPECT_NEAR(u[k], w[k], 1e-5) << "of the robot without";
    }
  }
}

TEST(RateCost, IsRefusedWhereItCannotBe) {
  const auto refused = [](auto&& make) { return refusal_of([&] { make(); }); };
  EXPECT_THAT(refused([] { looker(Multirotor{}, {1, 1, -1, 1}); }), HasSubstr("uav.R_rate"));
  EXPECT_THAT(refused([] { looker(Multirotor{}, {1, 1}); }), HasSubstr("uav.R_rate"));
  const std::string sentence =
      "uav has a cost of its inputs' rates, R_rate, expected the solver newton_riccati, which plans with it";
  const Team team = looker(Multirotor{}, {1, 1, 1, 1});
  EXPECT_EQ(refused([&] { Cgmres(team, default_horizon); }), sentence);
  EXPECT_EQ(refused([&] { Cmscgmres(team, default_horizon); }), sentence);
}

}  // namespace
}  // namespace sightline
