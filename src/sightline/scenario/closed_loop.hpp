/// A scenario's closed loop: its world and its controllers, as `sightline run` and a campaign fly it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "sightline/run/loop.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// @throws std::invalid_argument where the team changes in flight, or keeps apart as a swarm, and its solver, or one
/// that is to be compared, does not know how
void check_solvers(const Scenario& scenario);

/// The world that the scenario says, seen by its cameras where bodies have tags, with telemetry where robots are localized by view.
std::unique_ptr<World> make_world(const Scenario& scenario);

/// The solvers that can plan in a team that changes (TeamPlanner), in words: "newton_riccati".
std::string team_planners();
/// Whether the solver of that name can.
bool plans_in_a_changing_team(std::string_view solver);

/// Makes a scenario's flight one that is changed while it flies. No other solver flies it afterwards, by its text too: many cannot
/// follow a team that changes, and the text with the changes is flown again.
/// @throws std::invalid_argument for a team that plans in parts, and as check_solvers()
void make_tunable(Scenario& scenario);

/// In simulated time no deadline acts: a solver has the time it takes, and a run is the same on any machine.
void lift_deadline(SolverChoice& choice);

/// Each update of a large team is shared over these threads; the commands are the same whatever their number.
void share_updates(SolverChoice& choice, const std::shared_ptr<ThreadPool>& pool);

/// Makes solvers of that choice, for teams of one horizon.
MakeSolver solver_maker(SolverChoice choice, const Horizon& horizon);

/// Who steers a scenario: a solver of its team, one of each of its parts, or a TeamSwitcher of them where the team changes in flight.
class Controls {
 public:
  /// @throws as check_solvers(), and for a script with faults
  explicit Controls(const Scenario& scenario);

  /// Of the start.
  Controllers controllers() const;
  /// Of the solver of the start.
  KernelUse kernels() const;
  /// None for a team that stays.
  TeamSwitcher* team_switcher() const { return team_switcher_.get(); }
  /// Makes ready for the same flight again, with other starts and another seed. @return false: it has to be made anew, since what
  /// it did, or what becomes of its messages, follows from the flight
  bool restart();

 private:
  std::unique_ptr<Solver> solver_;
  bool talks_ = false;  // in parts, by messages
  std::unique_ptr<TeamSwitcher> team_switcher_;
};

/// Guard and loop of one flight in a world, as the scenario says. All memory is taken when it is made.
class ClosedLoop {
 public:
  /// @param world          of the scenario's team: make_world(), or another; it, the controllers, the clock and the
  ///                       sink outlive this
  /// @param controllers    a solver of the scenario's team
  /// @param sink           its items are copies of sized_sample()
  /// @param allocations    of the calling thread so far, where they are counted
  /// @param team_switcher  of the Controls, if the scenario has one
  /// @param stop           ends the flight at the next period once it is true
  /// @throws std::invalid_argument for a start, a disturbance or a sink that cannot be, named
  ClosedLoop(const Scenario& scenario, World& world, const Controllers& controllers, Clock& clock,
             Sink<Sample>& sink, std::int64_t (*allocations)() noexcept = nullptr,
             TeamSwitcher* team_switcher = nullptr, const std::atomic<bool>* stop = nullptr);
  ClosedLoop(const ClosedLoop&) = delete;
  ClosedLoop& operator=(const ClosedLoop&) = delete;

  /// Flies to the end, once; closes the sink.
  LoopOutcome fly() noexcept { return loop_.run(); }

 private:
  std::optional<Guard> guard_;
  std::optional<Localizer> localizer_;
  std::optional<Compensation> compensation_;
  Loop loop_;
};

}  // namespace sightline
