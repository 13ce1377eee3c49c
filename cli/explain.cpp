#include "sightline/analysis/explain.hpp"

#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/observation.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline::cli {

int explain(const ExplainCommand& command, const Parts& parts) {
  try {
    const Scenario read = command.scenario.read(parts);
    print("{}", to_string(sightline::explain(read.team, read.x0), read.team));
    for (const ObservationCycle& cycle : observation_cycles(read)) print("{}\n", to_string(cycle, read.team));
    return 0;
  } catch (const ScenarioError& error) {
    tell("{}\n", error.what());
    return 2;
  }
}

}  // namespace sightline::cli
