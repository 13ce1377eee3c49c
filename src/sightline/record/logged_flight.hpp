/// A flight with its log, as `sightline run` and programs fly one: it leaves the files of a run, and says what was wrong with it.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <string>
#include <vector>

#include "sightline/record/folder_lock.hpp"
#include "sightline/record/mcap.hpp"
#include "sightline/scenario/closed_loop.hpp"

namespace sightline {

/// Where a flight leaves its files, and where its comparisons leave theirs; for this process alone.
class RunFolder {
 public:
  /// @param in_parts  whether the flight is compared with that of one solver for the whole team
  /// @throws std::invalid_argument as FolderLock
  RunFolder(const std::filesystem::path& folder, const Scenario& scenario, bool in_parts = false);

  const std::filesystem::path& path() const { return locks_.front().folder(); }

 private:
  std::list<FolderLock> locks_;
};

/// What a flight has besides its scenario and its controllers.
struct FlightOptions {
  World* world = nullptr;                            ///< none: the scenario's, simulated
  TeamSwitcher* team_switcher = nullptr;             ///< of the Controls, if the scenario has one
  std::int64_t (*allocations)() noexcept = nullptr;  ///< of the calling thread so far, where they are counted
  const std::atomic<bool>* stop = nullptr;           ///< ends the flight at the next period once it is true
  std::function<void(double)> written{};  ///< as Log's; called by its thread, with the simulated time [s]
  McapWords flown{};                      ///< how it is flown, as Log's
  /// Puts another sink before the log's, which the prototype is an item of, and gives it back; it outlives the flight.
  std::function<Sink<Sample>&(Sink<Sample>& log, const Sample& prototype)> watched{};
  /// Flies the loop; none: ClosedLoop::fly(). Closes the sink where it does not.
  std::function<LoopOutcome(ClosedLoop&, Sink<Sample>&)> fly{};
  /// Completes the text of summary.json.
  std::function<std::string(std::string)> summarised{};
};

/// What a flight left, beside its files.
struct LoggedFlight {
  std::string summary;              ///< text of summary.json
  std::vector<std::string> faults;  ///< what makes the run a failure, a sentence each
  bool begun = false;               ///< the folder holds its files, and not those of an earlier flight
  bool logged = false;              ///< they are whole
  LoopOutcome outcome{};
};

/// Flies the scenario under its controllers; leaves run.mcap, timing.csv and summary.json in the folder. All memory is taken before
/// the first period.
/// @throws std::invalid_argument as make_world() and ClosedLoop, before anything is written
LoggedFlight fly_logged(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                        const Controllers& controllers, const FlightOptions& options = {});

}  // namespace sightline
