/// What several commands share. A command prints results on stdout and messages on stderr, and
/// returns the exit code: 0 done, 1 the flight failed or output was lost, 2 bad input.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "bridges/dds/fleet/bridge.hpp"
#include "sightline/log.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline::cli {

/// A scenario as given on a command line.
struct NamedScenario {
  std::filesystem::path file;
  std::vector<std::string> set;  ///< "KEY=VALUE"; replaces values of the file

  /// @throws std::invalid_argument as read_scenario()
  Scenario read(const Registry& registry) const { return read_scenario(file, registry, set); }
};

/// Default port of a page.
inline constexpr std::uint16_t page_port = 8765;

/// Whether and where a flight is shown on a page.
struct ShowOptions {
  bool show = false;
  bool tune = false;  ///< users of the page may change the flight
  ServeOptions serve{.port = page_port};
};
/// A sink that passes samples on to `log` and shows them on a page; of the component server.
std::unique_ptr<Sink<Sample>> show_on_page(Sink<Sample>& log, const Scenario& scenario,
                                           const Sample& prototype, const ServeOptions& options);

struct PartitionChoice;
/// Robots on links, instead of a simulated world.
struct LinkedFlight {
  LinkedWorld& world;
  Arming arming = Arming::real;
  const Interrupts& interrupts;
  std::atomic<bool>& stop;  ///< ends the loop
};
/// Flies a scenario as the command run. Its team plans in subteams, or, without a
/// partition, as one.
int fly(Scenario scenario, const RunFolder& folder, Clock& clock, const ShowOptions& view = {},
        const PartitionChoice* partition = nullptr, LinkedFlight* linked = nullptr);
/// Version of the library and of the compiler that built it.
std::string version_text();

}  // namespace sightline::cli
