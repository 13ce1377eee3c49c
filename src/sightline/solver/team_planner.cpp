#include <algorithm>

#include "sightline/base.hpp"
#include "sightline/solver.hpp"

namespace sightline {

std::vector<double> TeamPlanner::whole_plan() const {
  const std::size_t nu = at(ocp().nu());
  std::vector<double> u(at(ocp().horizon().N) * nu);
  for (int k = 0; k < ocp().horizon().N; ++k) plan(k, std::span(u).subspan(at(k) * nu, nu));
  return u;
}

void TeamPlanner::take_over(const Team& before, std::span<const double> plan_before) {
  const Team& team = ocp().team();
  if (plan_before.size() != at(ocp().horizon().N) * at(before.nu())) return;
  std::vector<double> u(at(team.nu()));
  for (int k = 0; k < ocp().horizon().N; ++k) {
    plan(k, u);
    for (const BodyId body : ocp().agent_bodies()) {
      const BodyId same = before.find(team.name(body));
      if (same.index < 0 || !before.is_agent(same)) continue;
      const int nu = team.model(body).nu();
      if (before.model(same).nu() != nu) continue;
      const std::size_t from = at(k) * at(before.nu()) + at(before.input_offset(same));
      std::copy_n(plan_before.begin() + static_cast<std::ptrdiff_t>(from), nu,
                  u.begin() + team.input_offset(body));
    }
    set_plan(k, u);
  }
}

TeamPlanner& team_planner_of(Solver& solver, std::string_view need) {
  if (TeamPlanner* const planner = solver.team_planner()) return *planner;
  throw_invalid(
      "the solver {} cannot hand over its plan, which {} needs, expected one that can, such as "
      "newton_riccati",
      solver.name(), need);
}

}  // namespace sightline
