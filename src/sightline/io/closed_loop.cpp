#include "sightline/io/closed_loop.hpp"

#include "sightline/io/safety_parts.hpp"

namespace sightline {
namespace {

std::optional<Guard> guard_of(const Scenario& scenario) {
  const std::optional<GuardOptions> options = guard_options(scenario);
  if (!options) return std::nullopt;
  return std::optional<Guard>(std::in_place, scenario.team, *options);
}

}  // namespace

ClosedLoop::ClosedLoop(const Scenario& scenario, const Controllers& controllers, Clock& clock,
                       Sink<Sample>& sink, std::int64_t (*allocations)() noexcept)
    : plant_(scenario.team, scenario.x0, plant_options(scenario)),
      sensor_(scenario.team, sensor_options(scenario)),
      guard_(guard_of(scenario)),
      loop_(plant_, sensor_, controllers, clock, sink,
            {.duration = scenario.simulation.duration,
             .period = scenario.horizon.dt,
             .path_interval = scenario.log.paths,
             .allocations = allocations,
             .guard = guard_ ? &*guard_ : nullptr,
             .late_plans = scenario.simulation.late_plans}) {}

}  // namespace sightline
