/// Closed loop of a scenario: the world and the controllers that `sightline run` and a campaign
/// use.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "sightline/run/clock.hpp"
#include "sightline/run/compensation.hpp"
#include "sightline/run/guard.hpp"
#include "sightline/run/localizer.hpp"
#include "sightline/run/loop.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/run/spsc_queue.hpp"
#include "sightline/run/team_switcher.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// @throws std::invalid_argument if the solver, or one of simulation.compare, lacks an ability that
/// the scenario needs (SolverAbilities)
void check_solvers(const Scenario& scenario);

/// The world that the scenario names. Adds cameras if there are cameras and tags, and telemetry if
/// robots are localized by vision.
std::unique_ptr<World> make_world(const Scenario& scenario);

/// Prepares a scenario for changes in flight. Clears `simulation.compare`, in its text too: many
/// solvers do not support a team that changes, and the text with the changes must be replayable.
/// @throws std::invalid_argument for a team that plans in parts, and as check_solvers()
void make_tunable(Scenario& scenario);

/// Removes the deadline for simulated time, so that a run gives the same result on any machine.
void lift_deadline(SolverChoice& choice);

/// Shares each update of a large team over these threads; the commands do not depend on their
/// number.
void share_updates(SolverChoice& choice, const std::shared_ptr<ThreadPool>& pool);

/// Returns a function that makes solvers of that choice, for teams with one horizon.
MakeSolver solver_maker(SolverChoice choice, const Horizon& horizon);

/// Controllers of a scenario: a solver of its team, one for each part, or a TeamSwitcher of them if
/// the team changes in flight.
class Controls {
 public:
  /// @throws as check_solvers(), and for a script with faults
  explicit Controls(const Scenario& scenario);

  /// Controllers of the initial team.
  Controllers controllers() const;
  /// Kernels of the initial solver.
  KernelUse kernels() const;
  /// Null for a team that does not change.
  TeamSwitcher* team_switcher() const { return team_switcher_.get(); }
  /// Prepares for another flight of the scenario, with other starts and another seed.
  /// @return false if new Controls are necessary: the state of a TeamSwitcher or of simulated
  /// messages depends on the flight
  bool restart();

 private:
  std::unique_ptr<Solver> solver_;
  bool talks_ = false;  // plans in parts, with simulated messages
  std::unique_ptr<TeamSwitcher> team_switcher_;
};

/// Guard and loop of one flight in a world, as the scenario specifies. The constructor allocates
/// all memory.
class ClosedLoop {
 public:
  /// @param world          of the scenario's team, from make_world() or another; the world, the
  ///                       controllers, the clock and the sink must outlive this object
  /// @param controllers    solvers of the scenario's team
  /// @param sink           its items are copies of sized_sample()
  /// @param allocations    returns the allocations of the calling thread so far; null: not counted
  /// @param team_switcher  of the Controls, if the scenario has one
  /// @param stop           true ends the flight at the next period
  /// @throws std::invalid_argument for an invalid start, disturbance or sink, with its name
  ClosedLoop(const Scenario& scenario, World& world, const Controllers& controllers, Clock& clock,
             Sink<Sample>& sink, std::int64_t (*allocations)() noexcept = nullptr,
             TeamSwitcher* team_switcher = nullptr, const std::atomic<bool>* stop = nullptr);
  ClosedLoop(const ClosedLoop&) = delete;
  ClosedLoop& operator=(const ClosedLoop&) = delete;

  /// Runs the flight to its end, once; closes the sink.
  LoopOutcome fly() noexcept { return loop_.run(); }

 private:
  std::optional<Guard> guard_;
  std::optional<Localizer> localizer_;
  std::optional<Compensation> compensation_;
  Loop loop_;
};

}  // namespace sightline
