/// The certified views of a team: what each observer knows of its target, and its command.
///
/// A robot has at most one view in force, of a target that it observes. A certified view that is not
/// observed any more stays in force until that of another observer of the target is certified. From
/// then on the latter keeps its set, so there is no period in between without a certified view.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "sightline/loop.hpp"
#include "sightline/run/team_barrier.hpp"
#include "sightline/run/view_odometry.hpp"
#include "sightline/safety/slow_down.hpp"
#include "sightline/safety/view_filter.hpp"

namespace sightline {

class TeamView {
 public:
  /// A view that became certified, ceased to be, or was handed over.
  struct Change {
    BodyId robot;
    EventKind kind;
  };

  /// Both arguments must outlive the object.
  TeamView(const Team& team, const GuardOptions& options);

  /// Takes what each robot observes, and its limits, which must outlive the next call.
  void follow(const Membership& now) noexcept;
  /// Takes the estimates of robots that are localized by vision, for each body; empty: none is. They
  /// must outlive the next keep_views().
  void accept_poses(std::span<const PoseEstimate> poses) noexcept { poses_ = poses; }
  /// Changes u (nu) to inputs that keep the states in their sets.
  void keep_views(double t, const TeamSituation& now, std::span<double> u) noexcept;
  /// Judges the inputs u (nu) that the robots receive, after keep_views().
  void judge(std::span<const double> u) noexcept;

  /// One record for each robot.
  std::span<const ViewRecord> records() const noexcept { return records_; }
  /// The views that changed in this period; of the first period all.
  std::span<const Change> changes() const noexcept { return changes_; }

 private:
  struct Observer {
    const CertifiedView* view;
    bool is_observed, is_in_force;           // the target by the robot's couplings; the view
    std::size_t robot, x, u, nx, nu;         // index among the robots; offsets and lengths
    std::vector<double> u_min, u_max, next;  // limits now; a command, at last the applied one
    const InputLimits* limits;               // in force
    SlowEstimate estimate;
    SlowState own;    // of the robot, as the filter uses it
    double most_lag;  // of `own` behind the predicted state [m]; of its velocity with `odometry` [m/s]
    double left_at = -infinity;  // when `own` was farther behind the last time [s]
    ViewBounds::Known known;     // greatest motion of the estimate
    ViewBounds::Known followed;  // greatest way from the estimate to a measurement
    bool is_known = false;       // the target has a position in this period
    double seen_at = 0.0;        // time of `target` [s]
    ViewTarget target{};
    Vec3<double> ahead{};                           // from `target` to the measured position [m]
    ViewReserve missed = ViewReserve::age;          // what is not as assumed; `command`: all is
    bool is_judged = false, was_certified = false;  // since the view is in force
    std::optional<SlowDown> slow_down{};            // of a target that does on request
    std::optional<OdometryFrame> odometry{};        // of a robot that is localized by vision
  };

  void see(double t, const TeamSituation& now, Observer& of) const noexcept;
  Vec3<double> follow_own(const TeamSituation& now, Observer& of, bool follows,
                          const Sight<double>& seen) const noexcept;
  bool is_sure(const TeamSituation& now, const Observer& of, const Vec3<double>& target) const noexcept;
  void approach(Observer& of, const Vec3<double>& p) const noexcept;
  void slow_down(const TeamSituation& now, Observer& of, std::span<double> u) noexcept;
  bool keeps_requests(std::size_t robot, std::span<const double> u) const noexcept;
  bool has_view_in_force(std::size_t robot) const noexcept;
  void choose_views() noexcept;

  const Team& team_;
  const GuardOptions& options_;
  std::vector<Observer> observers_;
  std::span<const PoseEstimate> poses_;
  std::vector<double> no_inputs_;  // as many zeros as a model has inputs, or more
  std::vector<ViewRecord> records_;
  std::vector<Change> changes_;
};

/// Of a view whose target slows down on request.
SlowDownOptions slow_down_options(const CertifiedView& view, double period);

/// @throws std::invalid_argument for a view without a filter, or a second one of an observer
void validate_views(const Team& team, const GuardOptions& options);

}  // namespace sightline
