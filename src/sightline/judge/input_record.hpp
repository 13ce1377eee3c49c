/// The inputs of a run: whether they were within their limits, and what they cost, gathered update by update.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sightline/judge/chatter.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Whether all numbers of a sample are finite: its states, and of an update its inputs, applied and raw.
bool all_finite(const Sample& sample) noexcept;

/// What is claimed of inputs, by the limits, weights and rates in force at each sample: the one judge of inputs. Allocates nothing
/// after its construction.
class InputRecord {
 public:
  explicit InputRecord(const Scenario& scenario);

  /// Takes the next update. Robots that are absent have no inputs.
  /// @param present  the team as it is at the sample
  void add(const Sample& sample, const PresentTeam& present) noexcept;

  /// Takes states that no update followed. Where a later sample comes, the loop missed a period there, and the inputs of the last
  /// update were held through it.
  void add_states(const Sample& sample, const PresentTeam& present) noexcept;

  /// Whether all applied inputs of the last update were within their limits in force, to 1e-9.
  bool within() const noexcept { return within_; }
  /// Components beyond their limits: of the inputs applied in all periods, and of the solvers' raw ones of all updates.
  std::int64_t beyond() const noexcept { return beyond_; }
  std::int64_t raw_beyond() const noexcept { return raw_beyond_; }
  /// Largest component of the raw inputs by absolute value.
  double largest_raw() const noexcept { return largest_raw_; }
  const Chatter& chatter() const noexcept { return chatter_; }

  /// What a robot's inputs cost and how fast they changed, while it was steered.
  struct Robot {
    BodyId body;
    std::size_t u, nu;             // offset and length of its inputs
    double energy = 0.0;           ///< sum of dt u'Ru of the applied inputs [s]
    double rate_ratio = 0.0;       ///< largest rate of an applied input over its rate_max; 0 without rate_max
    std::vector<double> before{};  // the applied inputs of the update before
    double time_before = 0.0;      // [s]
    bool has_before = false;
  };
  /// In the order of the team.
  const std::vector<Robot>& robots() const noexcept { return robots_; }
  /// Of all robots [s].
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
  std::int64_t held_beyond_ = 0;  // if the states that were taken last are of a missed period
  double largest_raw_ = 0.0;
};

}  // namespace sightline
