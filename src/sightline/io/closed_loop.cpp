#include "sightline/io/closed_loop.hpp"

namespace sightline {

ClosedLoop::ClosedLoop(const Scenario& scenario, const Controllers& controllers, Clock& clock,
                       Sink<Sample>& sink, std::int64_t (*allocations)() noexcept)
    : plant_(scenario.team, scenario.x0,
             {.seed = scenario.simulation.seed,
              .disturbances = scenario.simulation.disturbances,
              .period = scenario.horizon.dt}),
      sensor_(scenario.team, {.seed = scenario.simulation.seed,
                              .noise = scenario.simulation.disturbances.noise,
                              .delay = scenario.simulation.disturbances.measurement_delay,
                              .period = scenario.horizon.dt}),
      loop_(plant_, sensor_, controllers, clock, sink,
            {.duration = scenario.simulation.duration,
             .period = scenario.horizon.dt,
             .path_interval = scenario.log.paths,
             .allocations = allocations}) {}

}  // namespace sightline
