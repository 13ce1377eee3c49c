/// Changes of the team in flight: a thread of its own prepares the next solver.
///
/// The next solver takes over one period after the event that requests it.
///
///   period k      the loop's update; then look(): an event fires, the thread gets a request
///   meanwhile     the thread changes the membership, makes the Team, its Ocp and solver, transfers
///                 the plan of the robots in both teams, and takes up to 30 steps on the state
///                 predicted for period k + 1.  If any of it fails, nothing has changed; of several
///                 events each is then tried alone
///   period k + 1  swap(): exchanges pointers; the thread receives the previous solver and frees it
///
/// In simulated time the loop waits for the thread, so that a run does not depend on thread timing.
/// With a steady clock the present team continues until the next is ready, and an event reports the
/// delay. The control path does not allocate, lock or throw.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/base/service_thread.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/ocp/event_monitor.hpp"
#include "sightline/ocp/tuned_script.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/solver/team_planner.hpp"

namespace sightline {

/// The solver, the robots without a solver, and the membership of one team.
struct Phase {
  std::unique_ptr<Solver> solver;
  TeamPlanner* planner = nullptr;  // part of the solver
  std::optional<Controller> controller;
  std::vector<UncontrolledRobot> uncontrolled{};
  Membership membership{};
};

class TeamSwitcher {
 public:
  /// @param make  makes solvers for teams of this horizon; called on the thread
  /// @param tuned  events that arrive in flight, one a period; null: none
  /// @throws std::invalid_argument for the first fault that faults_of() finds in the script, and if
  ///         the solver is no TeamPlanner; std::system_error if the machine provides no thread
  TeamSwitcher(ActiveTeam start, const Script& script, MakeSolver make,
               std::shared_ptr<TunedScript> tuned = {});
  ~TeamSwitcher();
  TeamSwitcher(const TeamSwitcher&) = delete;
  TeamSwitcher& operator=(const TeamSwitcher&) = delete;

  /// Whether a requested team has neither taken over nor been refused.
  bool pending() const noexcept { return pending_; }
  /// The present phase. The loop takes the first one from here.
  Phase& present() noexcept { return present_; }
  const Phase& present() const noexcept { return present_; }
  /// All bodies that are ever present.
  const Team& world() const noexcept { return world_; }

  /// Sets, before the first period, the start states of bodies that join later (nx of the world).
  void set_start(std::span<const double> x) { start_.assign(x.begin(), x.end()); }
  /// Greatest number of events() that can wait.
  std::size_t events_max() const noexcept { return reported_.capacity(); }

  /// Any thread: passes on an event's signal. @return whether the script has a signal of that name
  bool signal(std::string_view name) noexcept { return monitor_.signal(name); }

  // Called on the control thread, each period.

  /// Whether no change is being prepared.
  bool is_ready() const noexcept { return hand_.load(std::memory_order_acquire) == Hand::control; }
  /// Applies the pending change if it is ready; waits for it if `wait`.
  /// @param x  present states of the world, which bring the new solver's memory into the cache
  /// @return whether the team has changed
  bool swap(double t, const ValidStates& x, std::span<const double> u, bool wait) noexcept;
  /// Evaluates triggers after the update at t, and requests the changes. The next solver continues
  /// from this update's plan.
  /// @param ages  age of the knowledge of each body [s]; empty: all is new
  void look(double t, const ValidStates& x, std::span<const double> u, std::span<const double> ages) noexcept;
  /// Events that occurred or took effect since clear_events().
  std::span<const Event> events() const noexcept { return reported_; }
  void clear_events() noexcept { reported_.clear(); }

 private:
  enum class Hand { control, thread };  // owner of the request and the next phase

  struct Request {
    double t = 0.0;
    std::vector<double> x, u;  // of the world
    std::vector<double> plan;  // [stage][input of the present team]
    std::vector<std::size_t> events;
    bool settles = false;  // ramped weights have reached their final values
  };

  void work() noexcept;
  void prepare() noexcept;
  void make_next(std::span<const std::size_t> events);
  void give_plan(TeamPlanner& planner) const;
  void predict(Phase& next) const;
  void tell(double t, EventKind kind, std::size_t event) noexcept;
  /// The number of a tuned event, behind those of the script.
  std::size_t number_of_tuned(std::size_t i) const noexcept { return script_.events.size() + i; }
  bool takes_tuned(double t) noexcept;
  void report_of(double t, std::size_t event) noexcept;

  Team world_;
  std::vector<double> start_;
  Script script_;
  EventMonitor monitor_;
  MakeSolver make_;
  std::shared_ptr<TunedScript> tuned_;
  std::size_t taken_ = 0;  // number of tuned events taken
  double period_ = 0.0;
  Phase present_;
  bool pending_ = false;
  double settles_at_;          // when weights that change now reach their final value [s]
  std::vector<char> ignored_;  // [event]: already reported
  std::vector<Event> reported_;

  // Passed between the two threads; hand_ names the owner.
  std::atomic<Hand> hand_{Hand::control};
  std::atomic<bool> stop_{false};
  ActiveTeam active_team_;
  Request request_;
  std::vector<std::size_t> refused_;  // events
  Phase next_;                        // without a solver: the team stays
  double next_settles_at_;
  ServiceThread thread_{"the change of teams"};
};

}  // namespace sightline
