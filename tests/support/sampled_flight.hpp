/// The samples of a scenario's flight, as the loop flies it.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sightline/run/controller.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/sample_sink.hpp"

namespace sightline::test {

inline std::vector<Sample> samples_of(const Scenario& scenario) {
  Controls controls(scenario);
  SimulatedClock clock;
  const std::unique_ptr<World> world = make_world(scenario);
  const Controllers controllers = controls.controllers();
  AllSamples sink(sized_sample(*world, controllers, controls.team_switcher()));
  ClosedLoop(scenario, *world, controllers, clock, sink, nullptr, controls.team_switcher()).fly();
  return std::move(sink.all);
}

}  // namespace sightline::test
