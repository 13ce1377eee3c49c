/// Who observes whom, where several robots learn their places by what they see: `best` of a [[shape]].
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "sightline/ocp/event/moment.hpp"

namespace sightline {

/// What the view of a target adds to the variance of the observer's position, by their distance.
struct ViewVariance {
  double step = 0.1;             ///< [m], > 0
  std::vector<double> values{};  ///< at 0, step, 2 step, ... [m^2], >= 0; infinite where it is not seen

  /// At a distance [m], by interpolation; infinite beyond the last.
  double at(double distance) const noexcept;
};

/// What a turn to another target costs: a share of the variance that is gained while nobody is seen, q t + sigma_b^2 t^2
/// with t = delay + angle / rate. It is gone soon after the turn, and that of a view stays: of shares from 0.1 to 1, 0.25
/// served best (docs/shapes.md).
struct TurnPrice {
  double delay = 0.2;         ///< [s], >= 0
  double rate = 1.2;          ///< of the turn [rad/s], > 0
  double walk = 0.05;         ///< sqrt(q) [m/sqrt(s)], >= 0
  double drift_sigma = 0.08;  ///< sigma_b, bias of the velocity that is told [m/s], >= 0
  double share = 0.25;        ///< in [0, 1]

  double operator()(double angle) const noexcept;
};

/// Each observer looks at one of the targets, at most `at_most` at each of them. A target that is no observer knows its
/// place; an observer knows it by whom it sees. So the variance of an observer is that of its target and that of the
/// view, and a path of views leads to one that knows its place.
struct ViewChoice {
  std::string name{};
  std::vector<AgentId> observers{};
  std::vector<BodyId> targets{};                  ///< observers may be among them
  std::vector<ViewVariance> variances{};          ///< [observer][target]
  int at_most = std::numeric_limits<int>::max();  ///< observers of one target, >= 1
  double margin = 0.01;  ///< standard deviation that a change has to be worth, beside the turn [m], >= 0
  double dwell = 1.0;    ///< for so long [s], > 0; so changes of one observer are as far apart
  TurnPrice price{};
  std::vector<int> first{};  ///< target of each observer at first, -1: none

  static constexpr int nobody = -1;

  /// @throws std::invalid_argument with a sentence: numbers out of range, an observer or a target that stands twice, no
  /// target that knows its place
  void check(const Team& team) const;
};

/// Chooses, once each period, from what is known then.
///
/// Shortest paths from the targets that know their places (Dijkstra), where a view costs its variance, and a view
/// that is not there yet costs its turn and margin^2 too. A change takes place once the paths have asked for one for
/// `dwell`, or at once for an observer that has nobody, and as soon as it closes no circle and exceeds no number. An
/// observer without any path goes on with the target it has, unless others need its place.
///
/// Targets that are absent, and observers that are not steered, are left out. Deterministic; allocates nothing after
/// construction.
class ViewChooser {
 public:
  explicit ViewChooser(const ViewChoice& choice);

  void look(const EventInstant& now) noexcept;
  /// Target of an observer, by their places in the choice; nobody where it has none.
  int target(std::size_t observer) const noexcept { return present_[observer]; }
  /// Whether the last look() changed it.
  bool changed(std::size_t observer) const noexcept { return changed_[observer] != 0; }

  /// The best for these poses, where nobody looks at anybody yet: for ViewChoice::first.
  static std::vector<int> first(const ViewChoice& choice, const Team& all, const EventContext& known);

 private:
  struct Node {
    BodyId body{};
    int observer = -1, target = -1;  // places in the choice
    bool there = false, done = false;
    double cost = 0.0;
    Sight<double> sight{};
  };

  void plan(const EventInstant& now) noexcept;
  void consider(Node& observer, const Node& target) noexcept;
  bool can_be(std::span<const int> targets) const noexcept;
  void turn(std::size_t observer, int target, double t) noexcept;

  ViewChoice choice_;
  std::vector<Node> nodes_;  // observers, then targets that are none
  std::vector<int> node_of_target_;
  std::vector<int> want_, present_, trial_;  // [observer]: targets
  std::vector<std::size_t> order_;           // observers, nearest to a known place first
  std::vector<int> used_;                    // [target]
  mutable std::vector<int> count_;           // [target]
  std::vector<double> since_, turned_;       // [observer] [s]
  std::vector<char> changed_, due_;
};

}  // namespace sightline
