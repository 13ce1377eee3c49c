/// Fault handling: the state estimate of each body (track.hpp), and fallback level (ladder.hpp) and
/// command of each robot.
///
///   accept_measurement()  takes a measurement with its times, returns the present state estimates
///   command()             scales or replaces the solvers' inputs by each robot's level
///   record()              stores the applied inputs for later predictions
///
/// The caller calls these once in each period, in this order, and follow() before them if the team
/// changes. A robot's partners are the bodies of all couplings and constraints that act on it. Its
/// task requires their positions. Throws and allocates only during construction; never locks or
/// prints.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include "sightline/ocp/active_team.hpp"
#include "sightline/safety/brake.hpp"
#include "sightline/safety/input_history.hpp"
#include "sightline/safety/ladder.hpp"
#include "sightline/safety/track.hpp"

namespace sightline {

struct SupervisorOptions {
  LadderTimes times{};
  LadderSigmas sigmas{};
  TrackLimits limits{};
  double slow_factor = 0.5;              ///< u* + slow_factor (u - u*) is applied when slowed, in [0, 1]
  double land_speed = 0.3;               ///< downwards [m/s], > 0
  double ground = 0.0;                   ///< height where landing ends [m]
  double brake_time = 0.4;               ///< time constant of the velocity in hold and land [s], >= 0.05
  double period = 0.01;                  ///< shortest time between two commands [s]; sizes the input history
  std::vector<double> command_delays{};  ///< of each body, from a command to its effect [s]; empty: none

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
};

/// An event of a body in this period: a robot changed its level, or a fault of its measurements
/// began.
struct Notice {
  BodyId body;
  std::variant<FallbackLevel, MeasurementFault> what;
};

/// Checks what the constructor of a Supervisor checks, and returns the options.
const SupervisorOptions& validate(const Team& team, const SupervisorOptions& options);

class Supervisor {
 public:
  /// @throws std::invalid_argument for options out of their range, and for a robot of more than 16
  ///         inputs
  Supervisor(const Team& team, const SupervisorOptions& options);
  Supervisor(const Supervisor&) = delete;  // its robots point into its team
  Supervisor& operator=(const Supervisor&) = delete;

  /// Updates the state estimate of all bodies at t [s].
  /// @param measured  states of all bodies as measured (nx)
  /// @param stamps  time of the measurement of each body [s]; unchanged: no new measurement
  /// @param sigma  of each body, standard deviation of an estimated position [m]; 0: measured;
  ///               infinity: unknown, then only states that do not depend on the position are
  ///               known. Empty: all are measured
  /// @return the estimated states of all bodies at t (nx), always finite, valid until the next call
  std::span<const double> accept_measurement(double t, std::span<const double> measured,
                                             std::span<const double> stamps,
                                             std::span<const double> sigma = {}) noexcept;
  /// Changes the inputs of robots that are slowed, hold, land or are grounded; afterwards all
  /// inputs are finite and within limits.
  /// @param x  states at which the commands take effect (nx)
  /// @param plan_ages  age of the plan of u for each body [s]; values of bodies that are no robots
  ///                   are ignored
  /// @param added  offset to the inputs (nu), such as wind compensation; the limits hold for the
  ///               sum
  /// @param u  inputs of all robots (nu)
  void command(double t, std::span<const double> x, std::span<const double> plan_ages,
               std::span<const double> added, std::span<double> u) noexcept;
  /// Records that u (nu) is applied from t [s] on.
  void record(double t, std::span<const double> u) noexcept { history_.record(t, u); }

  /// Takes presence, partners and limits from another membership. Absent bodies are not supervised.
  /// A body that joins starts anew on the level `valid`, as if measured at t.
  /// @param now  must outlive the next call; at first all bodies are present, coupled and limited
  ///             as in the team
  /// @param x  states of the bodies that join (nx)
  void follow(const Membership& now, double t, std::span<const double> x) noexcept;

  /// Events since the last call of accept_measurement().
  std::span<const Notice> notices() const noexcept { return notices_; }
  FallbackLevel level(BodyId robot) const noexcept { return robots_[robot_of_[at(robot)]].level; }
  /// Whether a measurement of each present body was accepted once.
  bool knows_all() const noexcept;
  /// Whether a robot is present that has no position and never had one.
  bool awaits_position() const noexcept;
  /// Whether the last measurement of a body was accepted.
  bool trusts(BodyId body) const noexcept { return tracks_[at(body)].trusted(); }
  /// Age of the body's state estimate at the last accept_measurement() [s]; infinity before the
  /// first measurement, 0 for an absent body.
  double age(BodyId body) const noexcept { return is_there(body) ? time_ - tracks_[at(body)].stamp() : 0.0; }

 private:
  struct Robot {
    BodyId body;
    std::size_t x, u, nx, nu;  // offsets and lengths
    std::vector<double> u_ref, u_min, u_max;
    std::vector<BodyId> partners;
    const InputLimits* limits;
    Brake brake;
    FallbackLevel level;
  };
  bool is_there(BodyId body) const noexcept { return presence_[at(body)] != Presence::absent; }
  FallbackLevel level_by_sigma(const Robot& robot) const noexcept;
  static std::vector<BodyId> partners_of(const Team& team, BodyId robot);

  Ages ages_of(const Robot& robot, std::span<const double> plan_ages) const noexcept;
  void apply(Robot& robot, std::span<const double> x, std::span<double> u) noexcept;
  void tell(const Notice& notice) noexcept;

  Team team_;
  SupervisorOptions options_;
  InputHistory history_;
  std::vector<Track> tracks_;
  std::vector<std::size_t> robot_of_;  // index into robots_ for each body; unused for other bodies
  std::vector<Robot> robots_;
  std::vector<Presence> presence_;
  std::vector<double> estimated_;
  std::vector<double> sigmas_;    // of each body, last received [m]
  std::vector<char> positioned_;  // whether its position was ever known since it joined
  std::vector<Notice> notices_;
  double time_ = 0.0;
};

}  // namespace sightline
