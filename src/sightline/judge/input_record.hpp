/// Inputs of a run: limit violations and cost, collected update by update.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sightline/judge/chatter.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// True if all numbers of a sample are finite: its states and, for an update, its applied and raw
/// inputs.
bool all_finite(const Sample& sample) noexcept;

/// Judges inputs by the limits, weights and rates in force at each sample; the only judge of
/// inputs. Allocates nothing after construction.
class InputRecord {
 public:
  explicit InputRecord(const Scenario& scenario);

  /// Adds the next update. Absent robots have no inputs.
  /// @param present  the team at the sample
  void add(const Sample& sample, const PresentTeam& present) noexcept;

  /// Adds states without an update. If a later sample follows, the loop missed a period there and
  /// the inputs of the last update were held through it.
  void add_states(const Sample& sample, const PresentTeam& present) noexcept;

  /// True if all applied inputs of the last update were within their limits in force, to 1e-9.
  bool within() const noexcept { return within_; }
  /// Number of components beyond their limits: of applied inputs in all periods, and of the
  /// solvers' raw inputs in all updates.
  std::int64_t beyond() const noexcept { return beyond_; }
  std::int64_t raw_beyond() const noexcept { return raw_beyond_; }
  /// Largest absolute component of the raw inputs.
  double largest_raw() const noexcept { return largest_raw_; }
  const Chatter& chatter() const noexcept { return chatter_; }

  /// Cost and largest rate of a robot's inputs while the robot was steered.
  struct Robot {
    BodyId body;
    std::size_t u, nu;             // offset and length of its inputs
    double energy = 0.0;           ///< sum of dt u'Ru of the applied inputs [s]
    double rate_ratio = 0.0;       ///< largest rate of an applied input over its rate_max; 0 without rate_max
    std::vector<double> before{};  // applied inputs of the previous update
    double time_before = 0.0;      // [s]
    bool has_before = false;
  };
  /// In the order of the team.
  const std::vector<Robot>& robots() const noexcept { return robots_; }
  /// Sum over all robots [s].
  double energy() const noexcept;

 private:
  void add_limits(const Robot& robot, const Sample& sample, const InputLimits& limits) noexcept;
  void add_costs(Robot& robot, const Sample& sample, const Agent& agent) noexcept;

  double period_;  // [s]
  std::vector<Robot> robots_;
  std::vector<double> u_min_, u_max_;  // of one robot
  Chatter chatter_;
  bool within_ = true;
  std::int64_t beyond_ = 0, raw_beyond_ = 0;
  std::int64_t held_beyond_ = 0;  // counts only if the last added states belong to a missed period
  double largest_raw_ = 0.0;
};

}  // namespace sightline
