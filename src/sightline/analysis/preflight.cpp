#include <fmt/format.h>

#include "sightline/analysis.hpp"
#include "sightline/analysis/observation.hpp"
#include "sightline/analysis/potential_page.hpp"
#include "sightline/analysis/view_band.hpp"
#include "sightline/safety/view_cost.hpp"

namespace sightline {

Preflight preflight(const Scenario& scenario) {
  Preflight p = check_scenario(scenario);
  if (!p.refusals.empty()) return p;
  std::vector<std::string> potentials, cycles;
  for (const JudgedCoupling& one : judge_couplings(scenario.team, {}, {}, scenario.x0)) {
    const Potential& potential = scenario.team.couplings()[one.coupling].term.potential;
    if (potential.as<ViewCost>() != nullptr) continue;  // the user has no say in its form
    const std::string_view name = potential.name();
    for (const std::string& sentence : one.verdict.warnings)
      potentials.push_back(fmt::format("couple[{}] {}: {}", one.coupling, name, sentence));
  }
  p.warnings.insert(p.warnings.begin(), potentials.begin(), potentials.end());
  for (const ObservationCycle& cycle : observation_cycles(scenario))
    if (norm(cycle.drift) > 0) cycles.push_back(to_string(cycle, scenario.team));
  p.warn(cycles);
  p.warn(unobservable_robots(scenario));
  return p;
}

}  // namespace sightline
