/// The control loop: once per period it measures, localizes, estimates, solves, checks, guards, passes
/// the gate and applies.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sightline/world/late_plan.hpp"

namespace sightline {

class Clock;
class Compensation;
class Guard;
class Localizer;
struct Sample;
template <class T>
class Sink;
class Solver;
class Team;
class TeamSwitcher;
class World;

/// The solvers of one loop, each with its own Ocp.
using Controllers = std::vector<std::reference_wrapper<Solver>>;

/// A message that a simulation sends to the events of a script.
struct TimedSignal {
  double at = 0.0;  ///< [s], >= 0
  std::string name;
};

struct LoopOptions {
  double duration = 60.0;      ///< [s]; round(duration / period) periods
  double period = 0.01;        ///< [s], that of each controller's horizon
  double path_interval = 0.1;  ///< between two samples with a predicted path [s]; 0: no paths
  /// Number of allocations of the calling thread so far; null: not counted.
  std::int64_t (*allocations)() noexcept = nullptr;
  /// If true, the loop ends at the next period.
  const std::atomic<bool>* stop = nullptr;
  /// Longest wait for room in the sink, if the clock waits for the log [s]. After that, samples are
  /// dropped.
  double log_patience = 30.0;
  /// Supervisor, search and barrier. Must be built for the world's team; not shared between loops.
  /// If null, the last valid measurements are the state estimate, and the gate alone checks
  /// commands.
  Guard* guard = nullptr;
  /// Estimates the poses of robots without a position sensor. Must be built for the world's team;
  /// not shared between loops. If null, states are as measured.
  Localizer* localizer = nullptr;
  /// Compensates command delays and disturbances. Must be built for the world's team; not shared
  /// between loops. If null, commands are assumed to act at once.
  Compensation* compensation = nullptr;
  std::vector<LatePlan> late_plans{};  ///< injected faults
  /// Changes the team in flight; its present solver is then the only controller. If null, the team
  /// stays.
  TeamSwitcher* team_switcher = nullptr;
  std::vector<TimedSignal> signals{};  ///< sent to the team switcher
  /// Minimum distance to each body [m]; an event reports a body that joins closer.
  std::vector<double> d_hard{};
  static constexpr double at_one_place = 0.01;  ///< value of missing entries of d_hard [m]
};

/// The result of a run.
struct LoopOutcome {
  std::int64_t updates = 0;  ///< periods in which the controllers were run
  std::int64_t missed = 0;   ///< periods that ended before they could begin
  std::int64_t dropped = 0;  ///< samples that found no room in the sink
  std::int64_t refused = 0;  ///< commands of a robot that were replaced, after a controller or at the gate
  std::int64_t max_allocations = 0;  ///< in one update: state in to command out, with its triggers
  bool finite = true;    ///< false: the world could not go on; for a simulated world, a state was not finite
  bool stopped = false;  ///< ended by the stop flag
};

/// A sample whose vectors are sized for a loop: the prototype of its sink's items.
/// @param team_switcher  switcher of the loop, or null
Sample sized_sample(const World& world, const Controllers& controllers,
                    const TeamSwitcher* team_switcher = nullptr);
/// The same for a world of that team that measures states alone.
Sample sized_sample(const Team& team, const Controllers& controllers,
                    const TeamSwitcher* team_switcher = nullptr);

/// Runs controllers in a world.
///
/// Period k, at t = k period: the loop measures the world and runs each controller in turn. If a
/// robot's command is not finite or not within its limits, the last good one is applied and an
/// event reports it. The sample goes into the sink, and the command to the world. If a steady clock
/// missed periods, the previous command stayed in force. If an update misses its deadline, the
/// previous plan stays in force.
///
/// The localizer runs after the measurement; the sample has the measurement unchanged. The guard
/// runs after the measurement and before the command. After the guard all states are ValidStates,
/// and the world takes a Command, which only the gate makes. Whatever is measured or planned, the
/// applied input is finite and within the limits in force. The loop does not allocate, lock, throw
/// or print.
class Loop {
 public:
  /// All arguments must outlive the loop.
  /// @throws std::invalid_argument unless each robot of the world is steered by exactly one
  ///         controller, each body of a controller is in the world with the same model, and the
  ///         sink's items are of sized_sample()
  Loop(World& world, const Controllers& controllers, Clock& clock, Sink<Sample>& sink,
       const LoopOptions& options);
  ~Loop();

  /// Runs all periods, once; closes the sink at the end.
  LoopOutcome run() noexcept;

 private:
  struct Stages;
  std::unique_ptr<Stages> stages_;
};

}  // namespace sightline
