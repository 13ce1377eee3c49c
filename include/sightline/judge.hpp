/// What a run is judged by: summary.json, distances, views, tracking errors, inputs, outcome.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/solver.hpp"

namespace sightline {

/// Of one robot. NaN: no data, for example errors without a known truth.
struct RobotLocalization {
  std::string name;
  double known_from;             ///< time of the first estimate [s]
  double rmse, heading_rmse;     ///< of the estimate, after settle [m], [rad]
  double anees;                  ///< mean of e^T P^-1 e of both, after settle [-]; 4 is consistent
  double sigma_max;              ///< largest standard deviation of the position, after settle [m]
  std::int64_t detections = 0;   ///< number of detections that the filter processed
  std::int64_t rejected = 0;     ///< number of these beyond the gate
  std::int64_t restarts = 0;     ///< number of restarts of the estimate
  double longest_without_sight;  ///< longest time between two accepted detections [s]
};

/// Outcome of a run: the first of failed, too_close and lost that applies, or else recovered.
enum class Outcome : std::uint8_t {
  recovered,  ///< every observer saw its target in time and sees it at the end
  lost,       ///< one observer did not
  too_close,  ///< a robot broke d_hard, although it could have braked at the start
  failed,     ///< a number was not finite, an applied input was beyond its limit, a solver gave no
              ///< plan for longer than hold_after, a wall was broken, or the run ended early
};
inline constexpr int outcome_count = 4;

std::string_view to_string(Outcome outcome);

/// Results of one robot, as in summary.json.
struct RobotResult {
  double energy = 0.0;                   ///< sum of dt u'Ru of the applied inputs [s]
  double rms_position_error = no_value;  ///< from rms_from on [m]
  double rms_heading_error = no_value;   ///< from rms_from on [rad]
};

/// Certified view of one observer in a run.
struct RobotView {
  std::string observer, target;
  double certified = 0.0;  ///< share of the updates in force in which it was certified; NaN: never in force
  double active = 0.0;     ///< share of these updates in which its filter changed the command
  std::int64_t uncertified = 0;  ///< number of events view_uncertified
};

/// A target that is out of view for longer is lost [s].
inline constexpr double view_lost_after = 0.5;

/// Results of one run: its row in the table of a campaign. NaN: no data.
struct RunResult {
  Outcome outcome = Outcome::failed;
  double min_distance = 0.0;        ///< of a robot to any other body, whole run [m]
  double time_to_first_view = 0.0;  ///< until each observer saw its target once after the request [s]
  double fraction_in_view = 0.0;    ///< of the run: all requested observations at once
  bool could_brake = true;          ///< at the start, all pairs in time for d_hard
  std::int64_t violations = 0;      ///< periods with an input beyond its limit, or with an avoidable
                                    ///< distance below d_hard
  std::array<std::int64_t, status_count> statuses{};
  double energy = 0.0;                ///< sum of dt u'Ru of the applied inputs, all robots [s]
  std::vector<RobotResult> robots{};  ///< in the order of the team
  double chatter = 0.0;  ///< largest share of the time in which an input alternated at the period
  double drift = 0.0;    ///< greatest steady speed away from a task at the end [m/s]; 0: none;
                         ///< NaN: the run was too short
  double longest_without_plan = 0.0;  ///< of all solvers [s]; 0: each update gave a plan
  double barrier_conflict = 0.0;      ///< largest share of the time in which the barrier found no command
                                      ///< within a robot's distances and walls; NaN: no barrier
  double longest_out_of_view = 0.0;   ///< of a target after its observer saw it first [s]
  double view_margin = 0.0;  ///< < 0: an observer lost its target for longer than 0.5 s; the greatest
      ///< slack of the potential's limit within 0.5 s, at its least; NaN: none observes
  double distance_margin = 0.0;  ///< least distance beyond d_hard, of pairs that could brake [m]; < 0:
                                 ///< too close; NaN: none is judged
  bool landed = false;           ///< a robot that was to fly on landed
  std::vector<RobotLocalization> localizations{};  ///< of the vision-localized robots
  std::vector<RobotView> views{};                  ///< in the order of [[certify_view]]
  std::string reason{};                            ///< first fault of a failed run, as a sentence; else empty
};

}  // namespace sightline
