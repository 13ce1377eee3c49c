/// The record of one control period that the loop passes to the log.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include "sightline/ocp/active_team.hpp"
#include "sightline/run/localizer.hpp"
#include "sightline/safety/ladder.hpp"
#include "sightline/solver/solver.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

/// Kinds of reported events.
enum class EventKind : std::uint8_t {
  missed_period,    ///< a steady clock's period was over before the update; value: periods missed
  solver_status,    ///< the status of a controller changed; value: the new Status as a number
  input_refused,    ///< a command was not finite or above its limit after the solver's clamp and was not
                    ///< applied
  samples_dropped,  ///< the log could not keep up; value: samples dropped so far
  // The fallback level of a robot changed, in the order of FallbackLevel; value: the body.
  valid,
  predicted,
  slowed,
  hold,
  land,
  grounded,
  // Measurements of a body are refused from now on, in the order of MeasurementFault; value: the
  // body.
  measurement_not_finite,
  measurement_heading,
  measurement_world,
  measurement_speed,
  measurement_jump,
  measurement_frozen,
  measurement_time,
  barrier_conflict,  ///< no command keeps all hard distances; value: the body
  // An event of the script; value: its index.
  event_occurred,  ///< its trigger fired
  event_in_force,  ///< its changes to the team are in force, or its stage has begun
  event_ignored,   ///< rejected, the team is unchanged; reported once
  team_late,       ///< the next team was not ready in time; value: periods
  pairs_left_out,  ///< more pairs of a swarm are near than there is room for; value: how many more
  added_too_near,  ///< a body joined closer to another than its minimum distance; value: the body
  search,          ///< a robot localized by vision searches for its target; value: the body
  found,           ///< the target is in view again; value: the body
  stale,           ///< a part of the team receives no predictions of this body any more; value: the body
  received,        ///< all parts receive them again; value: the body
};
inline constexpr int event_kinds = static_cast<int>(EventKind::received) + 1;
std::string_view to_string(EventKind kind);

struct Event {
  double time = 0.0;  ///< [s]
  EventKind kind{};
  int controller = 0;
  double value = 0.0;
};

/// Record of one update of one controller.
struct SolverRecord {
  Status status{};
  double residual = std::numeric_limits<double>::infinity();  ///< infinity: unknown
  int iterations = 0;
  double solve_us = 0.0;         ///< measured; written to timing.csv only
  std::int64_t allocations = 0;  ///< on the control thread, state in to command out
  int pairs = 0;                 ///< pairs of swarms in the constraints
  bool answered =
      true;  ///< false: the solver was not run: a late update is in progress, or a body was never measured
};

/// Effect of the barrier on one robot's command in one update.
struct BarrierRecord {
  bool active = false;                                       ///< it changed the command, or would have
  bool conflict = false;                                     ///< no command keeps all hard distances
  double reserve = std::numeric_limits<double>::infinity();  ///< smallest of all neighbours [m]
};

/// Record of one control period. All vectors are sized before the loop starts and never grow.
struct Sample {
  /// Content of the sample. `states`: no update; only time, x, truth_known, u in force, presence,
  /// levels and events. Written for a missed period, or after the last command.
  enum class Of : std::uint8_t { update, states };
  Of of = Of::update;
  double time = 0.0;      ///< of the measurement [s]
  std::vector<double> x;  ///< true states of all bodies (nx); measured ones if the truth is unknown
  bool truth_known = true;
  std::vector<Quaternion> attitudes{};  ///< true, of all bodies; no_attitude: it follows from x and u
  std::vector<double> measured;         ///< as measured, before the localizer (nx)
  std::vector<double> stamps{};         ///< time of each body's measurement [s]
  std::vector<Detection> detections{};  ///< the first detection_count are valid
  std::size_t detection_count = 0;
  std::vector<RobotMotion> motions{};  ///< the first motion_count are valid
  std::size_t motion_count = 0;
  std::vector<BodyBroadcast> broadcasts{};  ///< the first broadcast_count are valid
  std::size_t broadcast_count = 0;
  std::vector<PoseEstimate> estimates{};  ///< of each body, `known` if localized; empty: no localizer
  std::vector<DetectionFit> fits{};       ///< of detections, the first fit_count are valid
  std::size_t fit_count = 0;
  std::vector<double> u;                  ///< applied inputs (nu)
  std::vector<double> raw_u;              ///< the solvers' inputs before their clamp (nu)
  std::vector<SolverRecord> solvers;      ///< one for each controller
  std::vector<BarrierRecord> barriers{};  ///< one for each robot
  std::vector<Presence> presence{};       ///< of each body
  std::vector<FallbackLevel> levels{};    ///< of each body; all valid without a supervisor
  bool team_answered = false;             ///< a requested team took over, or was refused
  bool has_path = false;
  std::vector<double> path;      ///< predicted states (N+1 x nx), valid if has_path
  double path_step = 0.0;        ///< time between two predicted states [s]
  double path_time = 0.0;        ///< time of the first predicted state [s]
  std::vector<double> path_u{};  ///< planned inputs, as `path` (N+1 x nu); empty: not recorded
  double update_us = 0.0;        ///< measured: state in to command out, all controllers
  int event_count = 0;
  std::vector<Event> events = std::vector<Event>(8);  ///< room for all of a period that change the team
};

/// The tilt of a body's true attitude at the sample; `of_model` if the attitude is unknown.
Vec2<double> true_lean(const Vec2<double>& of_model, BodyId body, const Sample& sample) noexcept;
/// The true Sight of a body at the sample: its model at x and u, with its true tilt.
Sight<double> true_sight(const Team& team, BodyId body, const Sample& sample) noexcept;

}  // namespace sightline
