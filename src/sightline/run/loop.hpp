/// The control loop: measure, believe, solve, check, guard, apply; once per period.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sightline/run/clock.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/run/guard.hpp"
#include "sightline/run/ring.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/run/team_switcher.hpp"
#include "sightline/sim/fault.hpp"
#include "sightline/sim/plant.hpp"
#include "sightline/sim/sensor.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

/// Solvers of one loop, each with its own Ocp.
using Controllers = std::vector<std::reference_wrapper<Solver>>;

struct LoopOptions {
  double duration = 60.0;      ///< [s]; round(duration / period) periods
  double period = 0.01;        ///< [s], that of each controller's horizon
  double path_interval = 0.1;  ///< time between two samples with a predicted path [s]; 0: none has one
  /// Allocations of the calling thread so far, where they are counted.
  std::int64_t (*allocations)() noexcept = nullptr;
  /// Ends the loop at the next period once it is true.
  const std::atomic<bool>* stop = nullptr;
  /// Supervises, and keeps hard distances; of the plant's team, for this loop alone. None: measurements are
  /// believed and commands applied as they are.
  Guard* guard = nullptr;
  std::vector<LatePlan> late_plans{};  ///< injected
  /// Changes the team in flight; then its present solver is the only controller. None: the team stays.
  TeamSwitcher* team_switcher = nullptr;
  std::vector<TimedSignal> signals{};  ///< sent to it
  /// What a robot keeps from each body [m]: one that comes to be there nearer than that is told.
  std::vector<double> d_hard{};
  static constexpr double at_one_place = 0.01;  ///< of those that are missing [m]
};

/// What became of a run.
struct LoopOutcome {
  std::int64_t updates = 0;          ///< periods in which the controllers were asked
  std::int64_t missed = 0;           ///< periods that were over before they could begin
  std::int64_t dropped = 0;          ///< samples that found the sink full
  std::int64_t refused = 0;          ///< commands of a robot that were not applied
  std::int64_t max_allocations = 0;  ///< most in one update: state in to command out, and its triggers
  bool finite = true;                ///< false: a state of the plant was not, which ended the run
  bool stopped = false;              ///< ended by the stop flag
};

/// A sample with all its vectors sized for a loop: the prototype of its sink's items.
Sample sized_sample(const Team& plant, const Controllers& controllers);

/// Runs controllers against a plant.
///
/// Period k, at t = k period: the sensor's measurement goes to each controller in turn; of a robot whose
/// command is not finite or not within its limits the last good one is applied instead, and an event tells
/// it; the sample goes into the sink, and the plant steps. Where a steady clock missed periods, the plant
/// went on under the command it had. A guard comes after the sensor and before the plant; an update that is late
/// lets the plan before go on. Nothing in here allocates, locks, throws or prints.
class Loop {
 public:
  /// All of it must outlive the loop.
  /// @throws std::invalid_argument unless each robot of the plant is steered by exactly one controller and
  /// all that a
  ///         controller knows is there, of the same model, and the sink's items are of sized_sample()
  Loop(Plant& plant, Sensor& sensor, const Controllers& controllers, Clock& clock, Sink<Sample>& sink,
       const LoopOptions& options);

  /// Runs to the end, once; closes the sink.
  LoopOutcome run() noexcept;

 private:
  void check_steered() const;

  void update(double t, std::span<const double> measured, Sample& sample) noexcept;
  Solution ask(Controller& controller, double t, std::span<const double> believed) noexcept;
  void guard(double t, Sample& sample) noexcept;
  void change_team(double t) noexcept;
  void follow_team(double t) noexcept;
  void welcome(BodyId body, double t) noexcept;
  void rest(BodyId robot, double t) noexcept;
  const InputLimits& limits_of(BodyId robot) const noexcept;
  std::span<Controller> controllers() noexcept;
  void drift(double t, std::span<const double> believed, Sample& sample) noexcept;
  void command(int index, const Controller& controller, const Solution& solution, double t,
               Sample& sample) noexcept;
  void write_path(const Controller& controller, const Solution& solution, Sample& sample) noexcept;
  void tell(const Event& event) noexcept;

  Plant& plant_;
  Sensor& sensor_;
  Clock& clock_;
  Sink<Sample>& sink_;
  LoopOptions options_;
  std::vector<Controller> controllers_;               // of a team that stays
  std::vector<Presence> presence_, presence_before_;  // of the plant's bodies
  std::size_t signalled_ = 0;                         // signals sent
  std::vector<double> u_;  // applied, all robots of the plant; always within limits
  std::vector<double> u_min_, u_max_;
  std::vector<double> planned_at_, plan_ages_;  // of each body: time and age of its last good plan [s]
  std::vector<double> ages_;                    // of what was measured of each body [s]
  std::vector<Event> events_;                   // not yet in a sample
  Sample spare_;                                // written where the sink is full
  LoopOutcome outcome_;
};

}  // namespace sightline
