/// Chooses observers and targets among robots that are localized by vision: `best` of a [[shape]].
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "sightline/ocp/team.hpp"

namespace sightline {

struct EventContext;
struct EventInstant;

/// Variance that the view of a target adds to the observer's position, by their distance.
struct ViewVariance {
  double step = 0.1;             ///< [m], > 0
  std::vector<double> values{};  ///< at 0, step, 2 step, ... [m^2], >= 0; infinite: not detected

  /// Variance at a distance [m], by interpolation; infinite beyond the last value.
  double at(double distance) const noexcept;
};

/// Cost of a turn to another target [m^2]: a share of the variance gained without a view, q t +
/// sigma_b^2 t^2 with t = delay + angle / rate. That variance vanishes soon after the turn, while
/// the variance of a view stays. Of shares from 0.1 to 1, 0.25 gave the best result
/// (docs/shapes.md).
struct TurnPrice {
  double delay = 0.2;         ///< [s], >= 0
  double rate = 1.2;          ///< of the turn [rad/s], > 0
  double walk = 0.05;         ///< sqrt(q) [m/sqrt(s)], >= 0
  double drift_sigma = 0.08;  ///< sigma_b, bias of the measured velocity [m/s], >= 0
  double share = 0.25;        ///< in [0, 1]

  double operator()(double angle) const noexcept;
};

/// Each observer views one of the targets, with at most `at_most` observers for each target. A
/// target that is not an observer has a known position. The variance of an observer is that of its
/// target plus that of the view, so a path of views leads to a known position.
struct ViewChoice {
  std::string name{};
  std::vector<AgentId> observers{};
  std::vector<BodyId> targets{};                  ///< observers may be among them
  std::vector<ViewVariance> variances{};          ///< [observer][target]
  int at_most = std::numeric_limits<int>::max();  ///< observers of one target, >= 1
  double margin = 0.01;  ///< standard deviation that a change must gain, beside the turn [m], >= 0
  double dwell = 1.0;    ///< duration of that gain [s], > 0; least time between changes of one observer
  TurnPrice price{};
  std::vector<int> first{};  ///< target of each observer at first, -1: none

  static constexpr int nobody = -1;

  /// @throws std::invalid_argument with a sentence: numbers out of range, a duplicate observer or
  /// target, no target with a known position
  void check(const Team& team) const;
};

/// Chooses targets once each period, from the state of that period.
///
/// Computes shortest paths from the targets with known positions (Dijkstra). A view costs its
/// variance; a view that is not present also costs its turn and margin^2. A change takes place once
/// the paths have required it for `dwell`, or at once for an observer without a target. It must not
/// close a cycle or exceed at_most. An observer without any path keeps its target, unless others
/// need its place.
///
/// Absent targets and observers that are not steered are left out. Deterministic; allocates nothing
/// after construction.
class ViewChooser {
 public:
  explicit ViewChooser(const ViewChoice& choice);

  /// Updates the choice; to be called once each period.
  void look(const EventInstant& now) noexcept;
  /// Target of an observer, by indices in the choice; `nobody` if it has none.
  int target(std::size_t observer) const noexcept { return present_[observer]; }
  /// Whether the last look() changed the target.
  bool changed(std::size_t observer) const noexcept { return changed_[observer] != 0; }

  /// The best choice for these poses without any present views: for ViewChoice::first.
  static std::vector<int> first(const ViewChoice& choice, const Team& all, const EventContext& known);

 private:
  struct Node {
    BodyId body{};
    int observer = -1, target = -1;  // indices in the choice
    bool there = false, done = false;
    double cost = 0.0;
    Sight<double> sight{};
  };

  void plan(const EventInstant& now) noexcept;
  void consider(Node& observer, const Node& target) noexcept;
  bool can_be(std::span<const int> targets) const noexcept;
  void turn(std::size_t observer, int target, double t) noexcept;

  ViewChoice choice_;
  std::vector<Node> nodes_;  // observers, then targets that are not observers
  std::vector<int> node_of_target_;
  std::vector<int> want_, present_, trial_;  // [observer]: targets
  std::vector<std::size_t> order_;           // observers, nearest to a known position first
  std::vector<int> used_;                    // [target]
  mutable std::vector<int> count_;           // [target]
  std::vector<double> since_, turned_;       // [observer] [s]
  std::vector<char> changed_, due_;
};

}  // namespace sightline
