/// What the loop hands to the log, once per control period.
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

/// What can happen besides the ordinary.
enum class EventKind : std::uint8_t {
  missed_period,    ///< a steady clock's period was over before the update; value: periods missed
  solver_status,    ///< the status of a controller changed; value: the new Status as a number
  input_refused,    ///< a command was not finite or above its limit after the solver's clamp and was not
                    ///< applied
  samples_dropped,  ///< the log could not keep up; value: samples dropped so far
  // A robot came to another level of its ladder, in the order of FallbackLevel; value: the body.
  valid,
  predicted,
  slowed,
  hold,
  land,
  grounded,
  // Measurements of a body ceased to be believed, in the order of MeasurementFault; value: the body.
  measurement_not_finite,
  measurement_heading,
  measurement_world,
  measurement_speed,
  measurement_jump,
  measurement_frozen,
  measurement_time,
  barrier_conflict,  ///< no command keeps all hard distances; value: the body
  // An event of the script; value: its index.
  event_occurred,  ///< its trigger did
  event_in_force,  ///< the team is what it made of it, or its stage has begun
  event_ignored,   ///< it could not be, the team stays; told once
  team_late,       ///< the next team was not ready in time; value: periods
  pairs_left_out,  ///< more pairs of a swarm came near than there is room for; value: how many more
  added_too_near,  ///< a body came to be there nearer to another than it may; value: the body
  search,          ///< a robot that is localized by view searches for what it observes; value: the body
  found,           ///< it has it in view again; value: the body
  stale,           ///< a part of the team is not told any more where the robot will be; value: the body
  received,        ///< all are told again; value: the body
};
inline constexpr int event_kinds = static_cast<int>(EventKind::received) + 1;
std::string_view to_string(EventKind kind);

struct Event {
  double time = 0.0;  ///< [s]
  EventKind kind{};
  int controller = 0;
  double value = 0.0;
};

/// One controller's record of one update.
struct SolverRecord {
  Status status{};
  double residual = std::numeric_limits<double>::infinity();  ///< infinity: not known
  int iterations = 0;
  double solve_us = 0.0;         ///< measured; goes into timing.csv alone
  std::int64_t allocations = 0;  ///< on the control thread, state in to command out
  int pairs = 0;                 ///< of swarms, that were kept apart
  bool answered =
      true;  ///< else the solver was not asked: a late update is at work, or a body was never seen
};

/// What the barrier did to one robot's command in one update.
struct BarrierRecord {
  bool active = false;                                       ///< it changed the command, or would have
  bool conflict = false;                                     ///< no command keeps all hard distances
  double reserve = std::numeric_limits<double>::infinity();  ///< least of all neighbours [m]
};

/// One control period. All vectors are sized before the loop starts and never grow.
struct Sample {
  /// What stands in it. `states`: no update, only time, x, truth_known, u in force, presence, levels and events; of a period that
  /// was missed, or after the last command.
  enum class Of : std::uint8_t { update, states };
  Of of = Of::update;
  double time = 0.0;      ///< [s], of the measurement
  std::vector<double> x;  ///< true states of all bodies (nx); as measured where nobody knows them
  bool truth_known = true;
  std::vector<Quaternion> attitudes{};  ///< true ones of all bodies; no_attitude: it follows from x and u
  std::vector<double> measured;         ///< what the controllers saw, but of robots that are localized (nx)
  std::vector<double> stamps{};         ///< of each body, when it was as measured [s]
  std::vector<Detection> detections{};  ///< the first detection_count of them
  std::size_t detection_count = 0;
  std::vector<RobotMotion> motions{};  ///< the first motion_count of them
  std::size_t motion_count = 0;
  std::vector<BodyBroadcast> broadcasts{};  ///< the first broadcast_count of them
  std::size_t broadcast_count = 0;
  std::vector<PoseEstimate> estimates{};  ///< of each body, those that are localized; empty: none is
  std::vector<DetectionFit> fits{};       ///< of detections, the first fit_count of them
  std::size_t fit_count = 0;
  std::vector<double> u;                  ///< applied inputs (nu)
  std::vector<double> raw_u;              ///< the solvers' inputs before their clamp (nu)
  std::vector<SolverRecord> solvers;      ///< one for each controller
  std::vector<BarrierRecord> barriers{};  ///< one for each robot
  std::vector<Presence> presence{};       ///< of each body
  std::vector<FallbackLevel> levels{};    ///< of each body; all valid without a supervisor
  bool team_answered = false;             ///< a team that was asked for took over, or was refused
  bool has_path = false;
  std::vector<double> path;      ///< predicted states (N+1 x nx), where has_path
  double path_step = 0.0;        ///< time between two predicted states [s]
  double path_time = 0.0;        ///< of the first of them [s]
  std::vector<double> path_u{};  ///< planned inputs, as `path` (N+1 x nu); empty: nobody asks
  double update_us = 0.0;        ///< measured: state in to command out, all controllers
  int event_count = 0;
  std::vector<Event> events = std::vector<Event>(8);  ///< room for all of a period that change the team
};

/// The lean of a body's true attitude at the sample; that of its model where nobody knows it.
Vec2<double> true_lean(const Vec2<double>& of_model, BodyId body, const Sample& sample) noexcept;
/// What a body truly shows at the sample: its model at x and u, with its true lean.
Sight<double> true_sight(const Team& team, BodyId body, const Sample& sample) noexcept;

}  // namespace sightline
