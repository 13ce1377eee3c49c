/// Who is localized by whom.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sightline/estimate/measurement.hpp"

namespace sightline {

/// A robot, and whom it sees.
struct Localized {
  std::string name;
  bool is_anchor = false;  ///< its pose is known otherwise, as by motion capture
  std::vector<int>
      observes{};  ///< by number, those that it may be localized by; of an anchor they do not count
};

/// What is done about robots that are localized by each other in a circle.
enum class Cycles {
  refused,
  intersected,  ///< within a circle by covariance intersection: consistent, and far less accurate
};

/// Robots in tiers: an anchor is of tier 0, any other robot is localized by robots of lower tiers alone.
/// Information then goes one way, and none comes back to where it came from, to be counted again.
class LocalizationGraph {
 public:
  /// @throws std::invalid_argument with the robots' names, for a robot that no path leads from to an anchor, for
  /// one that observes itself
  ///         or a number that is none, and for a circle that is refused
  explicit LocalizationGraph(std::vector<Localized> robots, Cycles cycles = Cycles::refused);

  int robots() const noexcept { return static_cast<int>(robots_.size()); }
  const Localized& robot(int i) const noexcept { return robots_[static_cast<std::size_t>(i)]; }
  /// Robots of one circle have one tier.
  int tier(int robot) const noexcept { return tier_[static_cast<std::size_t>(robot)]; }
  /// All robots, lower tiers first.
  const std::vector<int>& order() const noexcept { return order_; }
  /// Whether an observer is localized by what it sees of a target.
  bool uses(int observer, int target) const noexcept;
  /// How the error of the target's pose goes on, for that observer.
  OtherError error_of(int observer, int target) const noexcept;

 private:
  std::vector<Localized> robots_;
  std::vector<int> tier_, circle_;  // robots with one number in circle_ reach each other
  std::vector<int> order_;
};

}  // namespace sightline
