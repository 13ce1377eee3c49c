/// The last stage before World::apply(), and the one place that says between which bounds an input must be.
///
///   limits   u_min(t) <= u <= u_max(t), those in force at t: always
///   rates    |u - u'| <= rate_max dt, u' applied a period before: as far as the limits leave room
///
/// Limits come before rates: an input that a limit narrows upon follows it at once. The same interval,
/// clamp(u' -+ rate_max dt, u_min, u_max), is that of a plan's first stage.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sightline/ocp/team.hpp"

namespace sightline {

/// Inputs of all robots (nu) that are finite and within their limits in force. Only a CommandGate makes them, so a World cannot
/// be given others. Valid until the gate's next pass().
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

/// Makes commands of one team. After construction nothing here allocates, locks, throws or prints.
class CommandGate {
 public:
  /// Robots have their own limits, and hold u* until the first pass().
  /// @param period  between two commands [s]
  CommandGate(const Team& team, double period);
  CommandGate(const CommandGate&) = delete;
  CommandGate& operator=(const CommandGate&) = delete;

  /// Limits in force from now on, one of each robot in the order of the team; they outlive the next call.
  void set_limits(std::span<const InputLimits> limits) noexcept;

  // Once in each period, in this order.

  /// Finds the limits in force at t [s].
  void open(double t) noexcept;
  /// Moves inputs u (nu) to the nearest within limits and rates.
  /// @param added  to u afterwards (nu): both hold for the sum; empty: nothing
  void keep_limits_and_rates(std::span<double> u, std::span<const double> added) const noexcept;
  /// The command u + added. A robot's inputs are replaced where one is not finite, by what was applied before, or beyond a limit,
  /// by the nearest within.
  Command pass(std::span<const double> u, std::span<const double> added) noexcept;

  /// Robots whose inputs the last pass() replaced.
  std::span<const BodyId> replaced() const noexcept { return replaced_; }
  /// As passed last.
  Command applied() const noexcept { return Command(applied_); }
  /// A robot's u*, to the nearest within its limits at t [s], into the inputs u of all robots (nu).
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
