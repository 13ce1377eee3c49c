/// Fault handling: for each body its state estimate (track.hpp), for each robot a
/// fallback level (ladder.hpp) and its command.
///
///   believe()  a measurement and its times in, the state estimate of all bodies at the present out
///   command()  the solvers' inputs in, scaled or replaced by each robot's level
///   record()   the inputs that are applied, for the predictions to come
///
/// once in each period, in this order; follow() before them where the team is another one. A robot's partners are
/// the bodies of all couplings and constraints that it feels: it cannot do its task without knowing where they are.
/// Nothing throws, allocates, locks or prints once it is made.
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
  double slow_factor = 0.5;  ///< u* + slow_factor (u - u*) is applied when slowed, in [0, 1]
  double land_speed = 0.3;   ///< downwards [m/s], > 0
  double ground = 0.0;       ///< height where landing ends [m]
  double brake_time = 0.4;   ///< of the velocity's decay in hold and land [s], >= 0.05
  double period = 0.01;      ///< shortest time between two commands [s]; sizes the memory of inputs
  std::vector<double> command_delays{};  ///< of each body, from a command to its effect [s]; empty: none

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
};

/// What happened to a body in this period: a robot changed its level, or a fault of its measurements began.
struct Notice {
  BodyId body;
  std::variant<FallbackLevel, MeasurementFault> what;
};

class Supervisor {
 public:
  /// @throws std::invalid_argument for options out of their range, and for a robot of more than 16 inputs
  Supervisor(const Team& team, const SupervisorOptions& options);
  Supervisor(const Supervisor&) = delete;  // its robots point into its team
  Supervisor& operator=(const Supervisor&) = delete;

  /// @param measured  states of all bodies as the sensor gives them (nx)
  /// @param stamps    time of the measurement of each body [s]; the same as before: there is nothing new
  /// @param sigma     of each body, standard deviation of a position that is estimated [m]; 0: it is measured; infinity: it
  ///                  is not known, and of the states only those that do not depend on it are. Empty: all are measured
  /// @return the estimated states of all bodies at t [s] (nx), always finite, valid until the next call
  std::span<const double> accept_measurement(double t, std::span<const double> measured,
                                             std::span<const double> stamps,
                                             std::span<const double> sigma = {}) noexcept;
  /// Changes the inputs of robots that are slowed, hold or land; all are finite and within limits afterwards.
  /// @param x          states that the commands meet (nx)
  /// @param plan_ages  age of the plan that u comes from, for each body; those of no robot do not count [s]
  /// @param added      to the inputs afterwards (nu), such as what holds robots against wind: limits hold for the sum
  /// @param u          inputs of all robots (nu)
  void command(double t, std::span<const double> x, std::span<const double> plan_ages,
               std::span<const double> added, std::span<double> u) noexcept;
  /// u (nu) is applied from t [s] on.
  void record(double t, std::span<const double> u) noexcept { history_.record(t, u); }

  /// Who is there now, whom each robot feels and within which limits it flies. Of a body that is absent nothing is
  /// judged; one that comes begins anew, on the level `valid`, as if it were seen at t.
  /// @param now  outlives the next call; at first all bodies are there, coupled and limited as the team says
  /// @param x    of those that come, where they are (nx)
  void follow(const Membership& now, double t, std::span<const double> x) noexcept;

  /// Since believe() was last called.
  std::span<const Notice> notices() const noexcept { return notices_; }
  FallbackLevel level(BodyId robot) const noexcept { return robots_[robot_of_[at(robot)]].level; }
  /// Whether a measurement of each present body was accepted once.
  bool knows_all() const noexcept;
  /// Whether a robot is there that is to find out where it is, and never knew it.
  bool awaits_position() const noexcept;
  /// Whether the last measurement of a body was accepted.
  bool trusts(BodyId body) const noexcept { return tracks_[at(body)].trusted(); }
  /// Age of the body's state estimate at the last believe() [s]; infinity before the first measurement.
  /// 0 of one that is absent.
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
  std::vector<std::size_t> robot_of_;  // of each body; those of no robot do not count
  std::vector<Robot> robots_;
  std::vector<Presence> presence_;
  std::vector<double> estimated_;
  std::vector<double> sigmas_;    // of each body, as told last [m]
  std::vector<char> positioned_;  // whether its position was known once since it is there
  std::vector<Notice> notices_;
  double time_ = 0.0;
};

}  // namespace sightline
