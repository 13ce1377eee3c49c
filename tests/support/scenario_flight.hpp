/// Flights of a scenario, as the loop flies them, kept in memory.
#pragma once

#include <memory>
#include <utility>

#include "sightline/run/controller.hpp"
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
  if (with_kkt) evaluate_kkt(sink, scenario.team, *controls.team_switcher());
  const LoopOutcome outcome =
      ClosedLoop(scenario, *world, controllers, clock, sink, nullptr, controls.team_switcher()).fly();
  return {std::move(sink.flown), outcome};
}

}  // namespace sightline
