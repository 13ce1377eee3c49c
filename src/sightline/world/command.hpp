/// Commands: the last stage before World::apply(), and the only place that bounds the inputs.
///
///   limits   u_min(t) <= u <= u_max(t), in force at t: always
///   rates    |u - u'| <= rate_max dt, u' applied one period before: as far as the limits allow
///
/// Limits take precedence over rates: when a limit tightens beyond an input, the input follows the
/// limit at once. The first stage of a plan uses the same interval, clamp(u' -+ rate_max dt, u_min,
/// u_max).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sightline/ocp/team.hpp"

namespace sightline {

/// Inputs of all robots (nu), finite and within the limits in force. Only a CommandGate creates
/// Commands, so a World receives no others. Valid until the gate's next pass().
class Command {
 public:
  std::size_t size() const noexcept { return u_.size(); }
  const double* data() const noexcept { return u_.data(); }
  const double* begin() const noexcept { return u_.data(); }
  const double* end() const noexcept { return u_.data() + u_.size(); }
  double operator[](std::size_t i) const noexcept { return u_[i]; }

 private:
  friend class CommandGate;
  explicit Command(std::span<const double> u) noexcept : u_(u) {}

  std::span<const double> u_;
};

/// Creates the commands of one team. After construction nothing here allocates, locks, throws or
/// prints.
class CommandGate {
 public:
  /// Each robot starts with its own limits. Until the first pass() its applied input is u*, clamped
  /// to those limits.
  /// @param period  between two commands [s]
  CommandGate(const Team& team, double period);
  CommandGate(const CommandGate&) = delete;
  CommandGate& operator=(const CommandGate&) = delete;

  /// Sets the limits in force from now on, one per robot in team order. They must outlive the next
  /// call.
  void set_limits(std::span<const InputLimits> limits) noexcept;

  // Called once in each period, in this order.

  /// Evaluates the limits in force at t [s].
  void open(double t) noexcept;
  /// Projects the inputs u (nu) onto the limits and rates.
  /// @param added  offset added to u afterwards (nu); limits and rates hold for the sum. Empty: no
  /// offset
  void keep_limits_and_rates(std::span<double> u, std::span<const double> added) const noexcept;
  /// Returns the command u + added. If an input of a robot is not finite, the robot keeps its
  /// previous inputs. Inputs beyond a limit are clamped.
  Command pass(std::span<const double> u, std::span<const double> added) noexcept;

  /// Robots whose inputs the last pass() replaced.
  std::span<const BodyId> replaced() const noexcept { return replaced_; }
  /// The command of the last pass().
  Command applied() const noexcept { return Command(applied_); }
  /// Writes a robot's u*, clamped to its limits at t [s], into the inputs u of all robots (nu).
  void rest(BodyId robot, double t, std::span<double> u) noexcept;

 private:
  struct Robot {
    BodyId body;
    std::size_t u, nu;  // offset and length
    const InputLimits* limits;
  };
  const Agent& agent(const Robot& robot) const noexcept { return team_.agent(robot.body); }

  Team team_;
  double period_;  // [s]
  std::vector<Robot> robots_;
  std::vector<double> u_min_, u_max_, applied_;  // of all robots (nu)
  std::vector<BodyId> replaced_;
};

}  // namespace sightline
