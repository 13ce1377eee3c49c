/// Flights of a scenario, as the loop flies them, kept in memory.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sightline/scenario.hpp"
#include "tests/support/team_flight.hpp"

namespace sightline {

/// @param with_kkt  evaluates the optimality of each update, outside of it
inline TeamFlight fly_scenario(const Scenario& scenario, bool with_kkt = false) {
  Controls controls(scenario);
  SimulatedClock clock;
  const Controllers controllers = controls.controllers();
  const std::unique_ptr<World> world = make_world(scenario);
  KeepSamples sink(sized_sample(*world, controllers, controls.team_switcher()));
  std::vector<double> u_before(static_cast<std::size_t>(scenario.team.nu()));
  if (with_kkt) {
    sink.after = [&](FlownPeriod& period) {
      Phase& phase = controls.team_switcher()->present();
      phase.controller->gather(scenario.team, test::valid(scenario.team, period.x),
                               u_before);  // as the update saw it
      u_before = period.u;
      period.kkt = phase.solver->kkt(period.time, phase.controller->states);
    };
  }
  const LoopOutcome outcome =
      ClosedLoop(scenario, *world, controllers, clock, sink, nullptr, controls.team_switcher()).fly();
  return {std::move(sink.flown), outcome};
}

}  // namespace sightline
