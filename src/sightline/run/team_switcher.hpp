/// Teams that follow one another in flight: the next team's solver is made and converged on a thread of its own, and
/// takes over one period after the event that asks for it.
///
///   period k      the loop's update; then look(): an event happens, the thread is told
///   meanwhile     the thread changes the roster, makes the Team, its Ocp and solver, gives it the plan of the
///                 robots that both teams have, and takes up to 30 steps on the state predicted for period k + 1.
///                 Where any of it fails, nothing was changed; of several events each is then tried by itself
///   period k + 1  swap(): pointers change hands; the solver that leaves goes back to the thread, which frees it
///
/// In simulated time the loop waits for the thread, so that a run is the same whatever the threads do; a steady
/// clock goes on under the team there is until the next is ready, and tells it. In the control path nothing
/// allocates, locks or throws.
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

/// Who steers, who is not controlled, who is there.
struct Phase {
  std::unique_ptr<Solver> solver;
  TeamPlanner* planner = nullptr;  // of the solver
  std::optional<Controller> controller;
  std::vector<UncontrolledRobot> uncontrolled{};
  Membership membership{};
};

class TeamSwitcher {
 public:
  /// @param make  of teams of this horizon; called on the thread
  /// @param tuned  events that come in flight, one a period; none: none do
  /// @throws std::invalid_argument for a script that has faults_of(), the first of them, and where the solver that is made
  /// is no TeamPlanner; std::system_error where the machine has no thread
  TeamSwitcher(ActiveTeam start, const Script& script, MakeSolver make,
               std::shared_ptr<TunedScript> tuned = {});
  ~TeamSwitcher();
  TeamSwitcher(const TeamSwitcher&) = delete;
  TeamSwitcher& operator=(const TeamSwitcher&) = delete;

  /// Whether a next team was asked for and has neither taken over nor been refused.
  bool pending() const noexcept { return pending_; }
  /// Of the team there is now. The loop takes the first one from here.
  Phase& present() noexcept { return present_; }
  const Phase& present() const noexcept { return present_; }
  /// Every body there will ever be.
  const Team& world() const noexcept { return world_; }

  /// Before the first period: where bodies stand that come to be there (nx of the world).
  void set_start(std::span<const double> x) { start_.assign(x.begin(), x.end()); }
  /// Most events() that can wait at one time.
  std::size_t events_max() const noexcept { return reported_.capacity(); }

  /// Any thread: hands over an event's signal. @return whether the script has one of that name
  bool signal(std::string_view name) noexcept { return monitor_.signal(name); }

  // The control thread, each period.

  /// Whether no change is being made.
  bool is_ready() const noexcept { return hand_.load(std::memory_order_acquire) == Hand::control; }
  /// Lets the pending change take place if it is ready, or once it is.
  /// @param x  states of the world now, that the new solver's memory is warmed with
  /// @return whether the team is another one now
  bool swap(double t, const ValidStates& x, std::span<const double> u, bool wait) noexcept;
  /// After the update at t, whose plan the next solver goes on from: asks for what happens now.
  /// @param ages  of what is known of each body [s]; empty: all is new
  void look(double t, const ValidStates& x, std::span<const double> u, std::span<const double> ages) noexcept;
  /// Since the last call of either; what happened, what took effect.
  std::span<const Event> events() const noexcept { return reported_; }
  void clear_events() noexcept { reported_.clear(); }

 private:
  enum class Hand { control, thread };  // whose the request and the next phase are

  struct Request {
    double t = 0.0;
    std::vector<double> x, u;  // of the world
    std::vector<double> plan;  // [stage][input of the present team]
    std::vector<std::size_t> events;
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
  std::size_t taken_ = 0;  // of the tuned events
  double period_ = 0.0;
  Phase present_;
  bool pending_ = false;
  double settles_at_;          // when the weights come to rest that move now [s]
  std::vector<char> ignored_;  // [event]: told already
  std::vector<Event> reported_;

  // Handed to and fro.
  std::atomic<Hand> hand_{Hand::control};
  std::atomic<bool> stop_{false};
  ActiveTeam active_team_;
  Request request_;
  std::vector<std::size_t> refused_;  // events
  Phase next_;                        // no solver: the team stays
  double next_settles_at_;
  ServiceThread thread_{"the change of teams"};
};

}  // namespace sightline
