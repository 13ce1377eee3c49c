#include "sightline/solver/distributed/partition_convergence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/potential/tracking.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

constexpr double stationary = 1e-9;  // [1/s]

}  // namespace

double horizon_cost(const Ocp& ocp, double time, std::span<const double> states, std::span<const double> u) {
  const Team& team = ocp.team();
  const double h = ocp.horizon().h();
  const std::size_t nu = at(team.nu());
  if (states.size() != at(team.nx()) || u.size() != nu * at(ocp.horizon().N)) {
    throw std::invalid_argument(fmt::format("{} states and a plan of {} inputs, expected {} and {}",
                                            states.size(), u.size(), team.nx(), nu * at(ocp.horizon().N)));
  }
  std::vector<double> x(states.begin(), states.end()), rate(x.size());
  double cost = 0.0;
  for (int k = 0; k < ocp.horizon().N; ++k) {
    const std::span<const double> now = u.subspan(at(k) * nu, nu);
    cost += h * stage_cost(team, time + k * h, x, now);
    for (int b = 0; b < team.bodies(); ++b) {
      const int from = team.state_offset(BodyId{b});
      team.model(BodyId{b}).f(&x[at(from)], now.data() + team.input_offset(BodyId{b}), &rate[at(from)]);
    }
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += h * rate[i];
  }
  for (const BodyId body : ocp.agent_bodies()) {
    const Agent& agent = team.agent(body);
    std::vector<double> x_ref(agent.Q_f.size());
    agent.x_ref(time + ocp.horizon().T, agent.model, x_ref);
    cost +=
        tracking_cost<double>({&x[at(team.state_offset(body))], x_ref.size()}, x_ref, agent.Q_f, {}, {}, {});
  }
  return cost;
}

std::unique_ptr<Solver> make_reference_solver(const Ocp& ocp) {
  return std::make_unique<NewtonRiccati>(
      ocp, NewtonRiccatiOptions{
               .max_newton_steps = 20, .tolerance = stationary, .max_krylov = 60, .krylov_stop = 1e-10});
}

std::vector<FromOptimum> partition_convergence(PartitionedSolver& solver, Solver& reference, double time,
                                               std::span<const double> states, int exchanges) {
  constexpr int attempts = 20;
  const Ocp& ocp = solver.ocp();
  TeamPlanner& planner = team_planner_of(reference, "a comparison with the optimum");
  planner.take_over(ocp.team(), solver.whole_plan());
  for (int i = 0; i < attempts && reference.kkt(time, states) > stationary; ++i)
    (void)reference.solve(time, states);
  if (!(reference.kkt(time, states) <= stationary)) return {};
  const std::vector<double> best = planner.whole_plan();
  const double best_cost = horizon_cost(ocp, time, states, best);

  std::vector<FromOptimum> distances;
  solver.send_all(time, states);
  for (int exchange = 0; exchange < exchanges; ++exchange) {
    const Solution solution = solver.solve(time, states);
    const std::vector<double> u = solver.whole_plan();
    FromOptimum& s = distances.emplace_back();
    for (std::size_t i = 0; i < u.size(); ++i) s.input = std::max(s.input, std::abs(u[i] - best[i]));
    s.cost = (horizon_cost(ocp, time, states, u) - best_cost) / best_cost;
    s.kkt = solution.residual;
  }
  return distances;
}

}  // namespace sightline
