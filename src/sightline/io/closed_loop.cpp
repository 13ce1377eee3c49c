#include "sightline/io/closed_loop.hpp"

namespace sightline {

ClosedLoop::ClosedLoop(const Scenario& scenario, const Controllers& controllers, Clock& clock,
                       Sink<Sample>& sink, std::int64_t (*allocations)() noexcept)
    : plant_(scenario.team, scenario.x0, plant_options(scenario)),
      sensor_(scenario.team, sensor_options(scenario)),
      loop_(plant_, sensor_, controllers, clock, sink,
            {.duration = scenario.simulation.duration,
             .period = scenario.horizon.dt,
             .path_interval = scenario.log.paths,
             .allocations = allocations}) {}

}  // namespace sightline
