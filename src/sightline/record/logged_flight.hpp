/// A flight with its log, for `sightline run` and for programs: writes the files of a run and
/// reports its faults.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <vector>

#include "sightline/record/folder_lock.hpp"
#include "sightline/scenario/closed_loop.hpp"

namespace sightline {

/// Folders for the files of a flight and of its comparisons; locked for this process.
class RunFolder {
 public:
  /// @param in_parts  true if the flight of a partitioned team is compared with one solver for the
  ///   whole team
  /// @throws std::invalid_argument as FolderLock
  RunFolder(const std::filesystem::path& folder, const Scenario& scenario, bool in_parts = false);

  const std::filesystem::path& path() const { return locks_.front().folder(); }

 private:
  std::list<FolderLock> locks_;
};

/// Options of a flight beyond its scenario and its controllers.
struct FlightOptions {
  World* world = nullptr;                            ///< null: the scenario's simulated world
  TeamSwitcher* team_switcher = nullptr;             ///< of the Controls, if the scenario has one
  std::int64_t (*allocations)() noexcept = nullptr;  ///< allocations so far of the calling thread, if counted
  const std::atomic<bool>* stop = nullptr;           ///< when true, the flight ends at the next period
  std::function<void(double)> written{};  ///< see Log; called by the log's thread with the simulated time [s]
  std::map<std::string, std::string> flown{};  ///< how it is flown, see Log
  /// Returns a sink that replaces the log's sink and forwards to it; `prototype` is one item of the
  /// log's sink. The returned sink must outlive the flight.
  std::function<Sink<Sample>&(Sink<Sample>& log, const Sample& prototype)> watched{};
  /// Flies the loop; if empty, ClosedLoop::fly(). Must close the sink if it does not call
  /// ClosedLoop::fly().
  std::function<LoopOutcome(ClosedLoop&, Sink<Sample>&)> fly{};
  /// Returns the final text of summary.json, given its first version.
  std::function<std::string(std::string)> summarised{};
};

/// Results of a flight, beyond its files.
struct LoggedFlight {
  std::string summary;              ///< text of summary.json
  std::vector<std::string> faults;  ///< reasons why the run failed, one sentence each
  bool begun = false;               ///< the folder contains this flight's files, not earlier ones
  bool logged = false;              ///< these files are complete
  LoopOutcome outcome{};
};

/// Flies the scenario with its controllers; writes run.mcap, timing.csv and summary.json into the
/// folder. Allocates all memory before the first period.
/// @throws std::invalid_argument as make_world() and ClosedLoop, before anything is written
LoggedFlight fly_logged(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                        const Controllers& controllers, const FlightOptions& options = {});

}  // namespace sightline
