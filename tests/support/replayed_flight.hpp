/// A flight in its log, and its replay.
#pragma once

#include <filesystem>
#include <utility>

#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/folder.hpp"

namespace sightline::test {

/// A flight of a scenario, logged in a folder of its own.
struct ReplayedFlight {
  Scenario scenario;
  Folder folder{"replayed_flight"};

  ReplayedFlight(Scenario of, double duration, Clock& clock) : scenario(std::move(of)) {
    scenario.simulation.duration = duration;
    const Controls controls(scenario);
    EXPECT_TRUE(fly_logged(scenario, folder.path(), clock, controls.controllers(),
                           {.team_switcher = controls.team_switcher()})
                    .logged);
  }

  std::filesystem::path file() const { return folder.path() / "run.mcap"; }
  RecordedFlight flight() const { return {file(), scenario.team, scenario.x0, scenario.horizon.dt}; }
};

/// The commands of a recorded flight, computed again under a scenario's solver.
inline CommandComparison replayed(const Scenario& scenario, RecordedFlight& flight) {
  const Controls controls(scenario);
  CommandComparison compared(flight, sized_sample(flight, controls.controllers(), controls.team_switcher()));
  ClosedLoop loop(scenario, flight, controls.controllers(), flight, compared, nullptr,
                  controls.team_switcher());
  (void)loop.fly();
  return compared;
}

}  // namespace sightline::test
