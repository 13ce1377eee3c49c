/// Which robot localizes itself by which other robots.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sightline/estimate/measurement.hpp"

namespace sightline {

/// A robot and the robots that it observes.
struct Localized {
  std::string name;
  bool is_anchor = false;       ///< its pose is known otherwise, for example by motion capture
  std::vector<int> observes{};  ///< numbers of the robots that may localize it; ignored for an anchor
};

/// Treatment of robots that localize each other in a cycle.
enum class Cycles {
  refused,
  intersected,  ///< covariance intersection within a cycle: consistent, but far less accurate
};

/// Robots in tiers. An anchor has tier 0; any other robot is localized only by robots of lower
/// tiers. So information flows in one direction and is never counted twice.
class LocalizationGraph {
 public:
  /// @throws std::invalid_argument with the robots' names: for a robot without a path to an anchor,
  ///   for a robot that observes itself or a number without a robot, and for a refused cycle
  explicit LocalizationGraph(std::vector<Localized> robots, Cycles cycles = Cycles::refused);

  int robots() const noexcept { return static_cast<int>(robots_.size()); }
  const Localized& robot(int i) const noexcept { return robots_[static_cast<std::size_t>(i)]; }
  /// Robots of one cycle have the same tier.
  int tier(int robot) const noexcept { return tier_[static_cast<std::size_t>(robot)]; }
  /// All robots, lower tiers first.
  const std::vector<int>& order() const noexcept { return order_; }
  /// True if the observer is localized by its sightings of the target.
  bool uses(int observer, int target) const noexcept;
  /// Time behaviour of the error of the target's pose, for that observer.
  OtherError error_of(int observer, int target) const noexcept;

 private:
  std::vector<Localized> robots_;
  std::vector<int> tier_, circle_;  // robots with equal circle_ reach each other
  std::vector<int> order_;
};

}  // namespace sightline
