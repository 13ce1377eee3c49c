/// Checks between the measurement and the controllers, and between them and the robots: the supervisor, the search and
/// the barrier of one team. They use one state estimate.
///
///   measurement -> supervisor -> state estimate -> solver -> supervisor -> search -> barrier -> applied
///
/// A robot that lands is not kept above the floor, and one that is grounded stays where it is. For a body
/// that was not measured for longer than hold_after the barrier uses the bounds at hold_after: beyond, it could
/// be anywhere, and a robot that fled from everywhere would never land. For the same reason it reckons with a position
/// that is estimated as if it were known within sigma_most at least.
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
  report,  ///< computes and tells, applies nothing
};

/// What the robots must keep from a body, and what they assume of it.
struct BodySafety {
  double d_hard = 0.6;     ///< centre to centre [m], > 0
  double speed_max = 1.5;  ///< of one that is no robot, or not heard [m/s], >= 0
  std::string
      robot{};  ///< of a robot that another part steers by a barrier of its own: its model's name; empty: it is none
};

/// Limits that a robot is given in flight.
struct LimitsToCome {
  BodyId robot;
  InputLimits limits;
};

struct GuardOptions {
  std::optional<SupervisorOptions> supervisor{};
  BarrierMode barrier = BarrierMode::off;
  BarrierOptions barrier_options{};
  double position_sigma = 0.0;       ///< of a measurement, each axis [m], >= 0
  std::vector<BodySafety> bodies{};  ///< of the team, in its order; those that are missing have the defaults
  double period = 0.01;              ///< of the commands [s]
  SearchOptions search{};            ///< of robots that are localized by view
  std::vector<BodyId> searchers{};   ///< these robots
  std::vector<double> command_delays{};  ///< of each body, from a command to its effect [s]; empty: none
  std::vector<LimitsToCome> limits_to_come{};  ///< the barrier reckons with the tightest there will be
  /// Threads that the barriers of at least `shared_from` robots are shared over; none: that of the caller alone. The result is
  /// the same.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 32;
};

class Guard {
 public:
  /// Standard deviation of an estimated position that the barrier reckons with at most [m].
  static constexpr double sigma_most = 0.5;

  /// @throws std::invalid_argument for options out of their range, and for a robot that the barrier cannot keep
  Guard(const Team& team, const GuardOptions& options);
  Guard(const Guard&) = delete;  // its robots point into its team
  Guard& operator=(const Guard&) = delete;

  /// The state estimate of all bodies at t [s], from measurements (nx) with a time for each body, as they come.
  /// @param sigma  of each body, standard deviation of a position that is estimated [m]; 0: it is measured; infinity: it is
  ///               not known. Empty: all are measured
  const ValidStates& accept_measurement(double t, std::span<const double> measured,
                                        std::span<const double> stamps,
                                        std::span<const double> sigma = {}) noexcept;
  /// Whether each body was believed once; before, nobody is asked for a plan.
  bool knows_all() const noexcept { return supervisor_ ? supervisor_->knows_all() : !awaits_position_; }
  /// Tells what the searchers' views are at t, in any order, after believe().
  void look(double t, std::span<const View> views) noexcept;
  // Both make of the controllers' inputs u (nu) what is commanded from t on, one after the other, after believe(). x
  // are the states that the commands meet: the estimate, or predicted over what is in flight.

  /// Where nothing better is known of a robot, the supervisor's command; of a searcher that has lost its view, the search's.
  /// @param plan_ages  of each body [s]; those of no robot do not count
  /// @param added      to the inputs afterwards (nu), such as what holds robots against wind: limits hold for the sum
  void fall_back(double t, const ValidStates& x, std::span<const double> plan_ages,
                 std::span<const double> added, std::span<double> u) noexcept;
  /// The nearest inputs that keep the hard distances; `added` as above.
  void keep_distances(double t, const ValidStates& x, std::span<const double> added,
                      std::span<double> u) noexcept;
  /// The inputs u (nu) are applied from t on.
  void record(double t, std::span<const double> u) noexcept;
  /// Whether the last measurement of a body is believed.
  bool trusts(BodyId body) const noexcept { return !supervisor_ || supervisor_->trusts(body); }

  /// The team is another one. Bodies that are absent keep nobody away, and nobody keeps away from them; robots that
  /// sink pass the floor. As Supervisor::follow().
  void follow(const Membership& now, double t, std::span<const double> x) noexcept;
  /// Robots that do not hear each other are uncooperative to each other. None: all hear. It outlives this.
  void set_connectivity(const Connectivity* connectivity) noexcept { connectivity_ = connectivity; }
  /// Of what is believed of each body at the last believe() [s].
  std::span<const double> ages() const noexcept { return ages_; }

  /// Of this period.
  std::span<const Event> events() const noexcept { return events_; }
  /// One for each robot; empty without a barrier.
  std::span<const BarrierRecord> barriers() const noexcept { return records_; }
  /// One for each body; all valid without a supervisor, and of those that are no robots.
  std::span<const FallbackLevel> levels() const noexcept { return levels_; }
  const Search& search() const noexcept { return search_; }
  /// None without a supervisor.
  const std::optional<Supervisor>& supervisor() const noexcept { return supervisor_; }

 private:
  struct Robot {
    BodyId body;
    std::size_t x, u, nx, nu;                    // offsets and lengths
    Barrier barrier, landing;                    // with and without the floor
    std::vector<double> u_min, u_max, reported;  // limits now
    double part = 1.0;                           // of the acceleration that they leave
    const InputLimits* limits;                   // in force
    EvasiveManeuver maneuver{};
    bool was_in_conflict = false;  // a period ago
  };
  /// Work space of a thread that keeps distances.
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
  std::vector<char> stale_;  // of each body, as told last
  std::optional<Supervisor> supervisor_;
  Search search_;
  std::vector<char> searches_;  // whether each searcher does, as told last
  std::vector<Robot> robots_;   // none without a barrier
  ValidStates estimated_;
  std::vector<double> ages_, stamps_, before_;
  std::vector<double> sigmas_;    // of each body, as told last [m]
  bool awaits_position_ = false;  // a robot that is there never knew where it is
  std::vector<Presence> presence_;
  std::vector<FallbackLevel> levels_;
  double oldest_;                      // age that the barrier reckons with [s]
  std::vector<int> kinds_;             // of each body; equal: robots that move alike; -1: no such robot
  std::vector<Sight<double>> sights_;  // of each body, of this period
  ThreatSelection threats_{0};         // the bodies that are there
  std::shared_ptr<ThreadPool> pool_;
  std::vector<Requester> requesters_;  // of each thread
  std::vector<BarrierRecord> records_;
  std::vector<Event> events_;
};

}  // namespace sightline
