#include "sightline/scenario/closed_loop.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

std::optional<Guard> guard_of(const Scenario& scenario) {
  const std::optional<GuardOptions> options = guard_options(scenario);
  if (!options) return std::nullopt;
  return std::optional<Guard>(std::in_place, scenario.team, *options);
}

/// What a robot keeps from each body: what the scenario asks for, else not to be at one place with it.
std::vector<double> hard_distances(const Scenario& scenario) {
  std::vector<double> d_hard;
  for (int i = 0; i < scenario.team.bodies(); ++i) {
    const std::optional<double> d = hard_distance(scenario, BodyId{0}, BodyId{i});
    d_hard.push_back(d.value_or(LoopOptions::at_one_place));
  }
  return d_hard;
}

}  // namespace

void check_solvers(const Scenario& scenario) {
  constexpr std::string_view able = "newton_riccati";
  const bool changes = changes_in_flight(scenario);
  if (!changes && scenario.team.swarms().empty()) return;
  std::vector<std::string> names = scenario.simulation.compare;
  names.insert(names.begin(), scenario.solver.name);
  for (const std::string& name : names) {
    if (name == able) continue;
    throw std::invalid_argument(
        changes ? fmt::format("the team changes in flight, which the solver {} cannot follow, expected {}",
                              name, able)
                : fmt::format("the solver {} knows no keep_apart, expected {}", name, able));
  }
}

Controls::Controls(const Scenario& scenario) {
  check_solvers(scenario);
  if (!changes_in_flight(scenario)) {
    solver_ = make_solver(scenario.solver, scenario.team, scenario.horizon);
    return;
  }
  succession_ = std::make_unique<Succession>(
      Roster(scenario.team, scenario.presence), scenario.script,
      [horizon = scenario.horizon, options = std::get<NewtonRiccatiOptions>(scenario.solver.options)](
          Team team) { return std::make_unique<NewtonRiccati>(Ocp(std::move(team), horizon), options); });
}

Controllers Controls::controllers() const {
  if (succession_) return {*succession_->present().solver};
  return {*solver_};
}

ClosedLoop::ClosedLoop(const Scenario& scenario, const Controllers& controllers, Clock& clock,
                       Sink<Sample>& sink, std::int64_t (*allocations)() noexcept, Succession* succession)
    : plant_(scenario.team, scenario.x0, plant_options(scenario)),
      sensor_(scenario.team, sensor_options(scenario)),
      guard_(guard_of(scenario)),
      loop_(plant_, sensor_, controllers, clock, sink,
            {.duration = scenario.simulation.duration,
             .period = scenario.horizon.dt,
             .path_interval = scenario.log.paths,
             .allocations = allocations,
             .guard = guard_ ? &*guard_ : nullptr,
             .late_plans = scenario.simulation.late_plans,
             .succession = succession,
             .signals = scenario.simulation.signals,
             .d_hard = hard_distances(scenario)}) {}

}  // namespace sightline
