/// Safety checks around the controllers: supervisor, search and barrier of one team, with one state
/// estimate.
///
///   measurement -> supervisor -> state estimate -> solver -> supervisor -> search -> barrier -> input
///
/// A robot that lands is not kept above the floor, and a grounded robot stays where it is. If a
/// body was not measured for longer than hold_after, the barrier uses its position bound at
/// hold_after. Growing the bound further would make every command infeasible, and no robot could
/// land. For the same reason the barrier limits the standard deviation of an estimated position to
/// sigma_most.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/base/thread_pool.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/run/valid_states.hpp"
#include "sightline/safety/barrier.hpp"
#include "sightline/safety/search.hpp"
#include "sightline/safety/supervisor.hpp"
#include "sightline/safety/threat_selection.hpp"
#include "sightline/solver/distributed/peers.hpp"

namespace sightline {

enum class BarrierMode {
  off,
  on,
  report,  ///< computes and reports, applies nothing
};

/// Distance that robots keep to a body, and the assumptions about it.
struct BodySafety {
  double d_hard = 0.6;     ///< centre to centre [m], > 0
  double speed_max = 1.5;  ///< of a body that is no robot, or is not received [m/s], >= 0
  std::string
      robot{};  ///< model name, if another part steers this body as a robot with its own barrier; else empty
};

/// Limits that a robot receives in flight.
struct LimitsToCome {
  BodyId robot;
  InputLimits limits;
};

struct GuardOptions {
  std::optional<SupervisorOptions> supervisor{};
  BarrierMode barrier = BarrierMode::off;
  BarrierOptions barrier_options{};
  double position_sigma = 0.0;           ///< of a measured position, each axis [m], >= 0
  std::vector<BodySafety> bodies{};      ///< in the order of the team; missing ones have the defaults
  double period = 0.01;                  ///< of the commands [s]
  SearchOptions search{};                ///< for robots that are localized by vision
  std::vector<BodyId> searchers{};       ///< robots that search
  std::vector<double> command_delays{};  ///< of each body, from a command to its effect [s]; empty: none
  std::vector<LimitsToCome> limits_to_come{};  ///< the barrier uses the tightest of all limits
  /// Threads for the barriers of `shared_from` robots or more; null: the calling thread alone. The
  /// result is the same.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 32;
};

/// Checks what the constructor of a Guard checks.
/// @throws std::invalid_argument as it does
void validate(const Team& team, const GuardOptions& options);

class Guard {
 public:
  /// Greatest standard deviation of an estimated position that the barrier uses [m].
  static constexpr double sigma_most = 0.5;

  /// @throws std::invalid_argument for options out of their range, and for a robot whose model the
  ///         barrier does not support
  Guard(const Team& team, const GuardOptions& options);
  Guard(const Guard&) = delete;  // its robots point into its team
  Guard& operator=(const Guard&) = delete;

  /// Updates the state estimate of all bodies at t [s].
  /// @param measured  states of all bodies (nx), unfiltered
  /// @param stamps  time of the measurement of each body [s]
  /// @param sigma  of each body, standard deviation of an estimated position [m]; 0: it is
  ///               measured; infinity: unknown. Empty: all are measured
  const ValidStates& accept_measurement(double t, std::span<const double> measured,
                                        std::span<const double> stamps,
                                        std::span<const double> sigma = {}) noexcept;
  /// Whether a measurement of each body was accepted once; without a supervisor, whether each
  /// present robot had a position. Until then the loop requests no plan.
  bool knows_all() const noexcept { return supervisor_ ? supervisor_->knows_all() : !awaits_position_; }
  /// Takes the views of the searchers at t [s], in any order, after accept_measurement().
  void look(double t, std::span<const View> views) noexcept;
  // fall_back() and then keep_distances(), after accept_measurement(), turn the controllers' inputs
  // u (nu) into the command from t on. x are the states at which the command takes effect: the
  // estimate, or predicted over the commands in flight.

  /// Replaces the input of a robot on a fallback level by the supervisor's, and that of a searcher
  /// without its view by the search's.
  /// @param plan_ages  of each body [s]; values of bodies that are no robots are ignored
  /// @param added  offset to the inputs (nu), such as wind compensation; the limits hold for the
  ///               sum
  void fall_back(double t, const ValidStates& x, std::span<const double> plan_ages,
                 std::span<const double> added, std::span<double> u) noexcept;
  /// Changes u to the nearest inputs that keep the hard distances; `added` as above.
  void keep_distances(double t, const ValidStates& x, std::span<const double> added,
                      std::span<double> u) noexcept;
  /// Records that the inputs u (nu) are applied from t [s] on.
  void record(double t, std::span<const double> u) noexcept;
  /// Whether the last measurement of a body was accepted.
  bool trusts(BodyId body) const noexcept { return !supervisor_ || supervisor_->trusts(body); }

  /// Switches to another membership. The barrier ignores bodies that are absent. Robots that sink
  /// may pass the floor. See Supervisor::follow().
  void follow(const Membership& now, double t, std::span<const double> x) noexcept;
  /// Sets which robots receive each other's messages. Robots that do not are uncooperative to each
  /// other. Null: all do. The object must outlive the guard.
  void set_connectivity(const Connectivity* connectivity) noexcept { connectivity_ = connectivity; }
  /// Age of the state estimate of each body at the last accept_measurement() [s].
  std::span<const double> ages() const noexcept { return ages_; }

  /// Events of this period.
  std::span<const Event> events() const noexcept { return events_; }
  /// One record for each robot; empty without a barrier.
  std::span<const BarrierRecord> barriers() const noexcept { return records_; }
  /// One level for each body; `valid` for all without a supervisor, and for bodies that are no
  /// robots.
  std::span<const FallbackLevel> levels() const noexcept { return levels_; }
  const Search& search() const noexcept { return search_; }
  /// Empty without a supervisor.
  const std::optional<Supervisor>& supervisor() const noexcept { return supervisor_; }

 private:
  struct Robot {
    BodyId body;
    std::size_t x, u, nx, nu;                    // offsets and lengths
    Barrier barrier, landing;                    // with and without the floor
    std::vector<double> u_min, u_max, reported;  // limits now; for BarrierMode::report
    double part = 1.0;                           // of the acceleration, within these limits
    const InputLimits* limits;                   // in force
    EvasiveManeuver maneuver{};
    bool was_in_conflict = false;  // in the previous period
  };
  /// Work space of a thread that runs barriers.
  struct Requester {
    ThreatSelection::Requester threats;
    std::vector<Neighbour> neighbours;  // of one robot
  };
  bool is_there(BodyId body) const noexcept { return presence_[at(body)] != Presence::absent; }

  double sigma_of(BodyId body) const noexcept;
  double delay_of(BodyId body) const noexcept {
    return options_.command_delays.empty() ? 0.0 : options_.command_delays[at(body)];
  }
  const Robot& robot_of(BodyId robot) const noexcept {
    return robots_[static_cast<std::size_t>(&team_.agent(robot) - team_.agents().data())];
  }
  bool is_grounded(BodyId body) const noexcept {
    return supervisor_ && team_.is_agent(body) && supervisor_->level(body) == FallbackLevel::grounded;
  }
  void see_all(std::span<const double> x) noexcept;
  bool gives_way(const Robot& robot, BodyId other) const noexcept;
  Neighbour neighbour_of(const Robot& robot, BodyId other) const noexcept;
  std::span<const Neighbour> neighbours_of(const Robot& robot, Requester& requester) const noexcept;
  void keep_distance(std::size_t robot, std::span<const double> x, std::span<double> u,
                     Requester& requester) noexcept;
  void tell(const Event& event) noexcept;
  void emit_stale(double t) noexcept;

  Team team_;
  GuardOptions options_;
  const Connectivity* connectivity_ = nullptr;
  std::vector<char> stale_;  // of each body, as last reported
  std::optional<Supervisor> supervisor_;
  Search search_;
  std::vector<char> searches_;  // whether each searcher searches, as last reported
  std::vector<Robot> robots_;   // empty without a barrier
  ValidStates estimated_;
  std::vector<double> ages_, stamps_, before_;
  std::vector<double> sigmas_;    // of each body, last received [m]
  bool awaits_position_ = false;  // a robot that is present has never had a position
  std::vector<Presence> presence_;
  std::vector<FallbackLevel> levels_;
  double oldest_;                      // greatest age that the barrier uses [s]
  std::vector<int> kinds_;             // of each body; equal: robots with like motion; -1: no such robot
  std::vector<Sight<double>> sights_;  // of each body, in this period
  ThreatSelection threats_{0};         // bodies that are present
  std::shared_ptr<ThreadPool> pool_;
  std::vector<Requester> requesters_;  // one for each thread
  std::vector<BarrierRecord> records_;
  std::vector<Event> events_;
};

}  // namespace sightline
