#include "sightline/analysis/explain.hpp"

#include <fmt/format.h>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/analysis/observation.hpp"
#include "sightline/analysis/view_band.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline::cli {

int explain(const ExplainCommand& command, const Parts& parts) {
  try {
    const Scenario read = command.scenario.read(parts);
    print("{}", to_string(sightline::explain(read.team, read.x0), read.team));
    for (const ObservationCycle& cycle : observation_cycles(read)) print("{}\n", to_string(cycle, read.team));
    const std::vector<ViewBand> bands = view_bands(read);
    for (const ViewBand& band : bands) {
      if (!band.same_as) {
        print("{}", to_string(band, read.team));
        continue;
      }
      const ViewBand& other = bands[*band.same_as];
      print("{} sees the tags of {}: as {} those of {}\n", read.team.name(band.observer),
            read.team.name(band.target), read.team.name(other.observer), read.team.name(other.target));
    }
    for (const std::string& sentence : unobservable_robots(read)) print("{}\n", sentence);
    return 0;
  } catch (const ScenarioError& error) {
    tell("{}\n", error.what());
    return 2;
  }
}

}  // namespace sightline::cli
