/// The barriers of all robots of a team: the bodies that each considers, and its command.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sightline/loop.hpp"
#include "sightline/safety/authority.hpp"
#include "sightline/safety/threat_selection.hpp"

namespace sightline {

/// A robot's abilities within its tightest limits, and its kind.
struct Ability {
  std::vector<double> u_min, u_max;
  Authority can;
  int kind;  // robots of one kind have like motion and rely on each other
};

/// The abilities of each robot. Robots of one kind use the least acceleration and the greatest push
/// and rise among them, so that each robot's assumptions about the others hold.
/// @throws std::invalid_argument for a robot whose model the barrier does not support
std::vector<Ability> abilities_of(const Team& team, const std::vector<LimitsToCome>& to_come);

/// Knowledge of all bodies in one period.
struct TeamSituation {
  bool is_there(BodyId body) const noexcept { return presence[at(body)] != Presence::absent; }
  bool is_grounded(BodyId body) const noexcept { return levels[at(body)] == FallbackLevel::grounded; }
  /// The limits of a robot at time t, less the offset; `first`: of its inputs in the team.
  void limit(const InputLimits& limits, double t, std::size_t first, std::span<double> u_min,
             std::span<double> u_max) const noexcept {
    limits.at(t, u_min, u_max);
    for (std::size_t k = 0; k < u_min.size(); ++k) u_min[k] -= added[first + k], u_max[k] -= added[first + k];
  }

  std::span<const double> x, estimated;  // states where the commands take effect; last estimates (nx)
  std::span<const double> absent;        // measured, of absent robots (nx); empty: none is in the world
  std::span<const double> ages, sigmas;  // of the estimates [s], of their positions [m]
  std::span<const Presence> presence;
  std::span<const FallbackLevel> levels;
  std::span<const double> added;  // offset to the inputs (nu); the limits hold for the sum
  const Connectivity* connectivity;
};

/// Options of all barriers of a team, which count the greatest of the command delays.
BarrierOptions counted_options(const GuardOptions& options);

/// A body as the barrier of a robot counts it, unless it gives way.
/// @param seen  where the robot's command acts if it `is_carried`, else at its last estimate
/// @param age  of the estimate [s]
/// @param sigma  standard deviation of the position relative to the robot [m]
Neighbour counted_neighbour(const GuardOptions& options, BodyId robot, BodyId other,
                            const Sight<double>& seen, bool is_carried, double age, double sigma) noexcept;

class TeamBarrier {
 public:
  /// Both arguments must outlive the object.
  /// @throws std::invalid_argument as validate_barriers() does
  TeamBarrier(const Team& team, const GuardOptions& options);

  /// Takes the limits of each robot, which must outlive the next call.
  void set_limits(std::span<const InputLimits> limits) noexcept;
  /// Changes u (nu) to the nearest inputs that keep the hard distances.
  void keep_distances(double t, const TeamSituation& now, std::span<double> u) noexcept;

  /// One record for each robot.
  std::span<const BarrierRecord> records() const noexcept { return records_; }
  /// Robots whose conflict began in this period.
  std::span<const BodyId> conflicts() const noexcept { return conflicts_; }

 private:
  struct Robot {
    BodyId body;
    std::size_t x, u, nx, nu;                       // offsets and lengths
    Barrier barrier, landing;                       // with and without the floor
    std::vector<double> u_min, u_max;               // limits now
    std::vector<double> wanted, kept;               // the inputs before and after the filter
    double part = 1.0;                              // of the acceleration, within these limits
    const InputLimits* limits;                      // in force
    EvasiveManeuver maneuver{}, maneuver_before{};  // of this period and of the previous one
    bool is_kept = false, lands = false;            // the barrier acts on the robot; it has no floor
    bool shares = false;           // in conflict in this period, or filtered again for one that is
    bool was_in_conflict = false;  // in the previous period
  };
  /// Work space of a thread that runs barriers.
  struct Requester {
    ThreatSelection::Requester threats;
    std::vector<Neighbour> neighbours;  // of one robot
    std::vector<BodyId> others;         // their bodies
  };

  const Robot& robot_of(BodyId robot) const noexcept { return robots_[team_.agent_index(robot)]; }
  void see_all(const TeamSituation& now) noexcept;
  double sigma_of(const TeamSituation& now, BodyId body) const noexcept;
  bool gives_way(const TeamSituation& now, const Robot& robot, BodyId other) const noexcept;
  Neighbour neighbour_of(const TeamSituation& now, const Robot& robot, BodyId other) const noexcept;
  std::span<Neighbour> neighbours_of(const TeamSituation& now, const Robot& robot,
                                     Requester& requester) const noexcept;
  double lacked(const TeamSituation& now, BodyId by, const Robot& robot) const noexcept;
  void keep_distance(const TeamSituation& now, std::size_t robot, std::span<const double> u,
                     Requester& requester) noexcept;
  void filter(const TeamSituation& now, std::size_t robot, std::span<const Neighbour> neighbours) noexcept;
  void filter_again(const TeamSituation& now, std::size_t robot, double more) noexcept;
  void share_conflicts(const TeamSituation& now) noexcept;

  const Team& team_;
  const GuardOptions& options_;
  std::vector<Robot> robots_;
  double oldest_;                      // greatest age that the barrier uses [s]
  std::vector<int> kinds_;             // of each body; equal: robots with like motion; -1: no such robot
  std::vector<double> before_;         // inputs of the previous period
  std::vector<Sight<double>> sights_;  // of each body, in this period
  ThreatSelection threats_;            // bodies that are present
  std::shared_ptr<ThreadPool> pool_;
  std::vector<Requester> requesters_;  // one for each thread
  std::vector<BarrierRecord> records_;
  std::vector<BodyId> conflicts_;
};

/// The tightest limits of a robot over the run, u_min and u_max (nu).
/// @throws std::invalid_argument if they leave no common value of an input
std::pair<std::vector<double>, std::vector<double>> tightest_limits(const Team& team, BodyId robot,
                                                                    const std::vector<LimitsToCome>& to_come);

/// Checks what the constructor of a TeamBarrier checks.
/// @throws std::invalid_argument for options out of their range, and for a robot whose model the
///         barrier does not support
void validate_barriers(const Team& team, const GuardOptions& options);

}  // namespace sightline
