/// Results of a run for summary.json, collected sample by sample.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/quantile.hpp"
#include "sightline/judge/drift.hpp"
#include "sightline/judge/input_record.hpp"
#include "sightline/judge/localization_summary.hpp"
#include "sightline/judge/plan_summary.hpp"
#include "sightline/judge/planned_view.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/judge/safety_summary.hpp"
#include "sightline/judge/time_in_force.hpp"
#include "sightline/judge/tracking_error.hpp"
#include "sightline/loop.hpp"
#include "sightline/potential.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Numbers of a run. NaN: no data.
struct SummaryValues {
  struct Times {
    double mean, median, p99, max;  ///< [µs]; above 65 536 values median and p99 to 0.5 %
  };
  struct Pair {
    std::string observer, target;
    std::string sensor;                 ///< name of the observer's camera, if it has one
    double distance_min, distance_max;  ///< after settle [m]
    double view_angle_max;              ///< after settle [rad], (71)
    double in_view_from;                ///< from here to the end in view [s]
    double in_view_fraction;            ///< after settle
    TimeInForce in_force;
    bool from_leaning = false;       ///< observer is a vehicle or its camera is body-fixed; only then:
    double view_angle_mean = 0.0;    ///< after settle [rad]
    double planned_view_rms = 0.0;   ///< flown minus planned (PlannedView::ahead before), after settle [rad]
    double planned_view_mean = 0.0;  ///< planned [rad]
  };
  /// A robot with a coupling that requests an observation, while no target was present.
  struct Idle {
    std::string observer;
    TimeInForce time;
  };
  struct Robot {
    std::string name;
    double rms_position_error;  ///< from rms_from on [m]
    double position_offset;     ///< steady part of that error: the length of its mean in G [m]
    double tracking_error;      ///< root mean square of the remaining error [m]
    double rms_heading_error;   ///< from rms_from on [rad]
    double energy;              ///< sum of dt u'Ru of the applied input [s]
    double tilt_max;            ///< after settle [rad]; of a vehicle or a robot with a body-fixed camera
    double planned_tilt_max, planned_tilt_rms;  ///< planned PlannedTilt::ahead before, if it tilts [rad]
    double input_rate_ratio;                    ///< largest rate of an applied input over its rate_max
  };
  struct Limit {
    std::string name;  ///< "keep_out uav0-uav1"
    double fraction;   ///< share of the time in force during which it was broken
    double longest;    ///< [s]
    double worst;      ///< excess, in the limit's unit; 0 while it holds
    std::string unit;  ///< unit of `worst`, as text
    TimeInForce in_force;
  };
  struct Chatter {
    std::string agent, input;
    double from;   ///< [s]
    double share;  ///< share of the time, (0, 1]
    double jump;   ///< mean change from period to period during chatter, in the unit of u
    bool region;   ///< a text limit affects the robot; a larger `smooth` softens it
  };
  struct Drift {
    std::string agent;
    Vec3<double> v;       ///< mean velocity at the end of the run, in G [m/s]
    bool from_reference;  ///< else from its anchors, or from its initial position
  };
  struct TriggeredEvent {
    double time;  ///< [s]
    std::string name;
  };

  std::int64_t updates = 0;
  double cost = 0.0;  ///< sum of dt l(x, u, t), all weights, masked or not [s]
  Times solve_us{};
  std::int64_t allocations_per_update = 0;            ///< maximum in one update
  std::array<std::int64_t, status_count> statuses{};  ///< updates by Status
  std::int64_t not_finite = 0;                        ///< samples with a state or an input that is not finite
  std::int64_t input_violations = 0;                  ///< components of the raw u beyond their limit in force
  std::int64_t applied_violations = 0;                ///< likewise of the applied u
  double max_abs_input = 0.0;                         ///< of the raw u
  int pairs_active_max = 0;                           ///< most pairs of swarms in one update
  int pairs_left_out_max = 0;                         ///< most near pairs without capacity in one update
  double min_distance = 0.0;                          ///< of a robot to any other body, whole run [m]
  std::vector<Pair> pairs;
  std::vector<Idle> idle_observers;
  std::vector<Robot> robots;
  std::vector<Limit> limits;
  std::vector<Chatter> chatter;  ///< inputs that alternate at the control period
  std::optional<std::vector<Drift>>
      drift;                           ///< robots that leave, fastest first; empty: the run was too short
  std::vector<TriggeredEvent> events;  ///< without status changes, which the log has; at most 1000
};

/// Collects SummaryValues. One thread.
class Summary {
 public:
  /// @param controllers  number of solver records in each sample
  Summary(const Scenario& scenario, std::size_t controllers);

  void add(const Sample& sample);

  SummaryValues values() const;
  /// Text of summary.json, keys as in docs/notation.md; a number that is not finite is null.
  std::string json() const;

  /// Number of samples with a state or an input, applied or raw, that is not finite; true if there
  /// is none.
  std::int64_t not_finite() const { return not_finite_; }
  bool finite() const { return not_finite_ == 0; }
  /// Number of components of applied inputs beyond their limits in force.
  std::int64_t applied_violations() const { return inputs_.beyond(); }
  /// Of the last sample: its stage cost, and the team.
  double stage_cost() const { return stage_cost_; }
  const PresentTeam& present() const { return present_; }
  /// Time without a plan.
  const PlanSummary& plans() const { return plans_; }
  /// Accuracy of vision-localized robots.
  const LocalizationSummary& localization() const { return localization_; }
  /// Hard distances, walls and barrier.
  const SafetySummary& safety() const { return safety_; }
  /// True if an observer did not have its target in view during the whole last 2 s.
  bool target_lost_at_end() const { return !out_of_view().empty(); }
  /// One sentence for each such observer.
  std::vector<std::string> out_of_view() const;

 private:
  struct View {
    Observation pair;
    double nearest, farthest, angle_max;  // after settle [m], [rad]
    double out_since, in_since;           // start of the present interval [s]; the other one is NaN
    std::int64_t settled = 0, seen = 0;   // samples after settle, and number of these in view
    bool in_force = true;
    TimeInForce time{};
    double angles = 0.0;        // sum after settle [rad]
    bool from_leaning = false;  // its planned angle is reported
    PlannedView planned{};
  };
  struct Limit {
    std::string name;
    Potential potential;
    BodyId a, b;
    double broken_since;  // [s]; NaN while it holds
    BodyId third{};       // third body of the potential; index -1: none
    double longest = 0.0, worst = 0.0;
    std::int64_t broken = 0, counted = 0;
    bool in_force = true;
    TimeInForce time{};
  };
  struct Robot {
    BodyId body;
    TrackingError error;
    bool leans = false;     // its tilt is reported
    double steepest = 0.0;  // tangent of the largest tilt
    PlannedTilt planned{};
    bool is_idle = false;  // requested to observe, and no target is present
    TimeInForce idle{};
  };

  const Sight<double>& sight(BodyId body) const { return sights_[at(body)]; }
  void add_view(const Observation& pair);
  void add_limit(const Potential& potential, BodyId a, BodyId b, BodyId third);
  void find_what_is_in_force();
  void find_limits_in_force(const std::vector<Coupling>& couplings,
                            const std::vector<Constraint>& constraints);
  bool is_there(BodyId body) const { return presence_[at(body)] != Presence::absent; }
  void add_robots(const Sample& sample);
  void add_views(const Sample& sample);
  void add_limits(double time);
  void add_solvers(const Sample& sample);
  void add_events(const Sample& sample);
  void add_states(const Sample& sample);
  void look(const Sample& sample);
  std::vector<SummaryValues::Chatter> chatter() const;

  Scenario scenario_;
  PresentTeam present_;
  std::vector<Presence> presence_;
  SafetySummary safety_;
  PlanSummary plans_;
  LocalizationSummary localization_;
  double period_;            // [s]
  std::vector<bool> leans_;  // of all bodies
  std::vector<View> views_;
  std::vector<Limit> limits_;
  std::vector<Robot> robots_;
  std::vector<Sight<double>> sights_;  // of all bodies at the last sample
  InputRecord inputs_;
  Drift drift_;

  std::int64_t updates_ = 0, not_finite_ = 0, allocations_ = 0;
  int pairs_ = 0, left_out_ = 0;
  double end_ = 0.0;  // of the last period [s]
  double cost_ = 0.0, stage_cost_ = 0.0;
  std::array<std::int64_t, status_count> statuses_{};
  Quantiles solve_us_;
  std::vector<Event> events_;
};

/// One line of the summary for people.
struct SummaryLine {
  std::string what, value;
};

/// Describes summary.json in words and units.
/// @throws std::runtime_error if the text is no such summary
std::vector<SummaryLine> summary_lines(std::string_view json);

/// Compares planned with flown values, in words and units, for pairs and robots that tilt: name,
/// planned, flown, root mean square of the difference.
/// @throws std::runtime_error if the text is no such summary
std::vector<std::array<std::string, 4>> planned_rows(std::string_view json);

/// Compares solvers: one line for each summary.json, with solve times and cost.
/// @throws std::runtime_error if a text is no such summary
std::vector<SummaryLine> comparison_lines(std::span<const std::string> summaries);

/// Describes partition.json; no line if it does not belong to the run of the summary.
/// @throws std::runtime_error if a text is no such file
std::vector<SummaryLine> partition_lines(std::string_view summary, std::string_view partition);

/// Writes summary.json into the folder, completely or not at all.
/// @return the fault as a sentence; empty on success
std::string write_summary(const std::filesystem::path& folder, std::string_view json);

}  // namespace sightline
