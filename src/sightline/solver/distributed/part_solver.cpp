#include "sightline/solver/distributed/part_solver.hpp"

namespace sightline {
namespace {

std::vector<AgentId> all_robots(const Team& team) {
  std::vector<AgentId> robots;
  for (int i = 0; i < team.bodies(); ++i)
    if (team.is_agent(BodyId{i})) robots.push_back(AgentId{BodyId{i}});
  return robots;
}

}  // namespace

PartSolver::PartSolver(const Team& team, const MakeSolver& make, PartExchange& exchange)
    : subteam_(team, all_robots(team), make, Others::all), exchange_(exchange) {}

Solution PartSolver::solve(double time, std::span<const double> states) noexcept {
  exchange_.receive(time, subteam_);
  const Solution solution = subteam_.solve(time, states);
  if (gives_plan(solution.status)) exchange_.send(time, subteam_.predictions());
  return solution;
}

}  // namespace sightline
