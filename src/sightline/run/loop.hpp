/// The control loop: measure, localize, estimate, solve, check, guard, pass the gate, apply; once per period.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sightline/run/clock.hpp"
#include "sightline/run/compensation.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/run/guard.hpp"
#include "sightline/run/localizer.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/run/spsc_queue.hpp"
#include "sightline/run/team_switcher.hpp"
#include "sightline/run/valid_states.hpp"
#include "sightline/solver/solver.hpp"
#include "sightline/world/command.hpp"
#include "sightline/world/fault.hpp"
#include "sightline/world/world.hpp"

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
  /// Where the clock waits for the log: the longest wait for room in the sink, before samples are dropped instead [s].
  double log_patience = 30.0;
  /// Supervises, and keeps hard distances; of the world's team, for this loop alone. None: the last valid measurements are the
  /// state estimate, and commands have no other check than the gate.
  Guard* guard = nullptr;
  /// Says where robots are that are not told; of the world's team, for this loop alone. None: states are as measured.
  Localizer* localizer = nullptr;
  /// Of late commands and disturbances; of the world's team, for this loop alone. None: commands are reckoned to act at once.
  Compensation* compensation = nullptr;
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
  std::int64_t updates = 0;  ///< periods in which the controllers were asked
  std::int64_t missed = 0;   ///< periods that were over before they could begin
  std::int64_t dropped = 0;  ///< samples that found the sink full
  std::int64_t refused = 0;  ///< commands of a robot that were replaced, of a controller or at the gate
  std::int64_t max_allocations = 0;  ///< most in one update: state in to command out, and its triggers
  bool finite = true;    ///< false: the world could not go on; a simulated one, where a state was not finite
  bool stopped = false;  ///< ended by the stop flag
};

/// A sample with all its vectors sized for a loop: the prototype of its sink's items.
/// @param team_switcher  of the loop, which changes the team
Sample sized_sample(const World& world, const Controllers& controllers,
                    const TeamSwitcher* team_switcher = nullptr);
/// In a world of that team that measures states alone.
Sample sized_sample(const Team& team, const Controllers& controllers,
                    const TeamSwitcher* team_switcher = nullptr);

/// Runs controllers in a world.
///
/// Period k, at t = k period: what the world measures goes to each controller in turn; of a robot whose
/// command is not finite or not within its limits the last good one is applied instead, and an event reports
/// it; the sample goes into the sink, and the command to the world. Where a steady clock missed periods, the
/// command before stayed in force. A localizer comes after the measurement, which the sample has as it was. A guard comes
/// after the measurement and before the command. If an update is late, the plan before stays in force. Behind the guard all
/// states are ValidStates, and the world takes a Command, which the gate alone makes: whatever is measured or planned, what
/// is applied is finite and within the limits in force. Nothing in here allocates, locks, throws or prints.
class Loop {
 public:
  /// All of it must outlive the loop.
  /// @throws std::invalid_argument unless each robot of the world is steered by exactly one controller and
  /// all that a
  ///         controller knows is there, of the same model, and the sink's items are of sized_sample()
  Loop(World& world, const Controllers& controllers, Clock& clock, Sink<Sample>& sink,
       const LoopOptions& options);
  Loop(const Loop&) = delete;  // its controllers point into what it was made of
  Loop& operator=(const Loop&) = delete;

  /// Runs to the end, once; closes the sink.
  LoopOutcome run() noexcept;

 private:
  void check_steered() const;

  std::int64_t allocations() const noexcept {
    return options_.allocations != nullptr ? options_.allocations() : 0;
  }
  Sample* claim_slot() noexcept;
  Measured localize(double t, const Measured& reported, Sample& sample) noexcept;
  bool apply(double t, std::int64_t periods) noexcept;
  void fill(Sample& sample, double t, std::span<const double> x, bool is_truth) const noexcept;
  void show_end(double t) noexcept;
  void move_events(Sample& sample) noexcept;
  void update(double t, const Measured& seen, Sample& sample) noexcept;
  Solution solve(Controller& controller, double t, const ValidStates& x) noexcept;
  void guard(double t, const ValidStates& x, Sample& sample) noexcept;
  bool change_team(std::int64_t k, double t) noexcept;
  void follow_team() noexcept;
  void follow_guard(double t, std::span<const double> x, std::span<const double> known) noexcept;
  void on_join(BodyId body, double t, std::span<const double> x) noexcept;
  const ValidStates& compensate(double t) noexcept;
  std::span<const double> added() const noexcept;
  std::span<const Vec2<double>> added_lean() const noexcept;
  void set_reference_inputs(Controller& controller, double t, const ValidStates& x) noexcept;
  void pass_gate(double t) noexcept;
  std::span<Controller> controllers() noexcept;
  void steer_uncontrolled(double t, const ValidStates& x, Sample& sample) noexcept;
  void command(int index, const Controller& controller, const Solution& solution, double t,
               Sample& sample) noexcept;
  void write_path(const Controller& controller, const Solution& solution, Sample& sample) noexcept;
  void emit(const Event& event) noexcept;

  World& world_;
  Clock& clock_;
  Sink<Sample>& sink_;
  LoopOptions options_;
  std::vector<Controller> controllers_;               // of a team that stays
  std::vector<Presence> presence_, presence_before_;  // of the world's bodies
  ValidStates measured_, met_;                        // as measured or localized; as the commands meet them
  const ValidStates* estimate_;                       // at the last update
  double lead_;                                       // from a command to its effect, at most [s]
  bool solvers_use_applied_ = false;                  // solvers are told what is applied
  std::size_t signalled_ = 0;                         // signals sent
  CommandGate gate_;
  std::vector<double> u_;  // of the controllers and the guard, all robots of the world, without what is added
  std::vector<double> none_;  // that is added without compensation
  std::vector<double> u_min_, u_max_;
  std::vector<double> planned_at_, plan_ages_;     // of each body: time and age of its last good plan [s]
  std::vector<double> ages_;                       // of what was measured of each body [s]
  std::vector<double> plan_;                       // inputs of one stage of a plan
  std::vector<Event> events_;                      // not yet in a sample
  Sample spare_;                                   // written where the sink is full
  std::chrono::steady_clock::time_point began_{};  // the last measurement
  std::int64_t allocated_ = 0;                     // before it
  bool log_is_stuck_ = false;                      // it had no room for as long as log_patience
  LoopOutcome outcome_;
};

}  // namespace sightline
