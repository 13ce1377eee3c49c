/// JSON of a flight for a page: the constant scene, and the state at one moment.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/estimator.hpp"
#include "sightline/judge/event_description.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// State of a flight at one time. An unknown value is NaN or empty.
struct ShownState {
  double time = 0.0;                               ///< [s]
  std::vector<std::optional<Sight<double>>> seen;  ///< of each body of the team; none: absent
  std::vector<double> u;                           ///< applied inputs, nu
  std::string_view status{};                       ///< of the first solver
  double residual = 0.0, solve_us = 0.0;
  int iterations = 0;
  std::vector<std::string_view> levels{};  ///< fallback levels of the bodies
  std::vector<char> requested{};           ///< of each pair: whether it is in force; empty: all are
  std::vector<char> barrier{};             ///< of each robot, whether the barrier acts
  std::vector<double> reserve{};           ///< of each robot: the barrier's reserve [m]
  std::vector<PoseEstimate> estimates{};   ///< of each robot; empty: no robot is localized by vision
  bool truth_known = true;                 ///< whether true poses are known, so that an estimate has an error
  /// Predicted positions of each robot [m]; empty between predictions.
  std::vector<std::vector<Vec3<double>>> paths{};
};

/// An event as text.
struct TriggeredEvent {
  std::int64_t number = 0;  ///< from 0
  double time = 0.0;        ///< [s]
  std::string words;
};

/// Writes scenes and moments of one scenario.
///
///   scene    {name, session, live, period, duration, solver, floor, ceiling, barrier,
///             wind: {v, gust}, faults: [{name, from, until}],
///             bodies: [{name, robot, agent, localized, hard, inputs, u_min, u_max}],
///             pairs: [{observer, target, alpha, d_min, d_max, mount, surface}],
///             surfaces: [{reach, scales, open, corners: [x, y, z, ..], triangles: [a, b, c, ..]}],
///             zones: [{body, surface, name, mount: {offset, turned, on_body}}],
///             prisms: [{polygon: [x, y, ..], low, high, keep}],
///             undrawn: [sentence]}
///   moment   {t, b: [[x, y, z, qx, qy, qz, qw]], p: [[in view, distance, angle]], u: [[..]],
///             status, residual, us, it, levels, barrier, reserve,
///             e: [[x, y, z, P_xx, P_xy, P_xz, P_yy, P_yz, P_zz, error, sigma]],
///             paths: [[x, y, z, ..]], events: [[number, time, words]]}
///
/// Arrays are in the order of the team's bodies; of its robots for u, barrier, reserve, e and
/// paths; of `pairs` for p. Lengths are in m, angles in rad, us in microseconds, wind in m/s^2.
/// null stands for absent or not finite values; levels, barrier, reserve, e, paths and events may
/// be omitted. The surface (LimitSurface) of a pair is in the frame of its sensor. That of a zone
/// is in the frame of its mount, or in G around its body. Prisms are those of [[safety.zone]].
/// `undrawn` names the limits without a surface.
class SceneJson {
 public:
  explicit SceneJson(const Scenario& scenario);

  /// @param session  unique for each flight, so that a page that reconnects detects another flight
  /// @param live  whether states arrive during the flight; if false, all are available at once
  std::string scene(std::string_view session, bool live) const;
  std::string moment(const ShownState& state, const std::vector<TriggeredEvent>& events) const;

  /// Of each pair: whether it is in force now.
  std::vector<char> requested(const PresentTeam& present) const;
  /// Text of a log's event, by its kind and value.
  std::string describe(std::string_view kind, double value) const;

  const Team& team() const { return team_; }
  /// Pairs of observer and target at any time of the flight.
  const std::vector<Observation>& pairs() const { return pairs_; }

 private:
  std::string name_, solver_;
  double period_, duration_;
  double floor_, ceiling_;  // of [safety] [m], else NaN
  std::vector<Zone> prisms_;
  bool has_barrier_ = false;
  Vec3<double> wind_;  // [m/s^2]
  double gust_;        // sigma [m/s^2]
  std::vector<Fault> faults_;
  std::vector<LatePlan> late_plans_;
  Team team_;
  std::vector<BodyId> robots_;
  std::vector<bool> localized_;      // of each body: whether by vision
  std::vector<Coupling> couplings_;  // at any time of the flight
  std::vector<Observation> pairs_;
  std::vector<double> hard_;  // hard distance of each body [m]; 0: none
  Script script_;
  std::shared_ptr<const TunedScript> tuned_;
};

}  // namespace sightline
