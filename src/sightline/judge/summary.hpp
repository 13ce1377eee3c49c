/// What a run is judged by: summary.json, gathered sample by sample.
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
#include "sightline/potential/potential.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// The numbers of a run. Not a number: there was nothing to compute it from.
struct SummaryValues {
  struct Times {
    double mean, median, p99, max;  ///< [µs]; of more than 65 536 the median and p99 within 0.5 %
  };
  struct Pair {
    std::string observer, target;
    double distance_min, distance_max;  ///< after settle [m]
    double view_angle_max;              ///< after settle [rad], (71)
    double in_view_from;                ///< in view from here to the end [s]
    double in_view_fraction;            ///< after settle
    TimeInForce in_force;
    bool from_leaning = false;     ///< by a vehicle, or by a camera that is fixed to the body; only then:
    double view_angle_mean = 0.0;  ///< after settle [rad]
    double planned_view_rms =
        0.0;  ///< of flown against planned PlannedView::ahead before, after settle [rad]
    double planned_view_mean = 0.0;  ///< as planned [rad]
  };
  /// A robot that was asked to observe, while nothing that it was to see was there.
  struct Idle {
    std::string observer;
    TimeInForce time;
  };
  struct Robot {
    std::string name;
    double rms_position_error;  ///< from rms_from on [m]
    double position_offset;     ///< steady part of that error: the length of its mean in G [m]
    double tracking_error;      ///< root mean square of the rest [m]
    double rms_heading_error;   ///< from rms_from on [rad]
    double energy;              ///< sum of dt u'Ru of the applied input [s]
    double tilt_max;  ///< after settle [rad], of a vehicle or one with a camera that is fixed to its body
    double planned_tilt_max, planned_tilt_rms;  ///< planned PlannedTilt::ahead before, where it leans [rad]
    double input_rate_ratio;                    ///< largest rate of an applied input over its rate_max
  };
  struct Limit {
    std::string name;  ///< "keep_out uav0-uav1"
    double fraction;   ///< of the time it was broken
    double longest;    ///< [s]
    double worst;      ///< excess, in the limit's unit; 0 while it holds
    std::string unit;  ///< of `worst`, in words
    TimeInForce in_force;
  };
  struct Chatter {
    std::string agent, input;
    double from;   ///< [s]
    double share;  ///< of the time
    double jump;   ///< mean from period to period meanwhile, as u
    bool region;   ///< the robot feels a limit as text, which `smooth` makes softer
  };
  struct Drift {
    std::string agent;
    Vec3<double> v;       ///< mean velocity of the end of the run, in G [m/s]
    bool from_reference;  ///< else from what it follows, or from where it was
  };
  struct TriggeredEvent {
    double time;  ///< [s]
    std::string name;
  };

  std::int64_t updates = 0;
  double cost = 0.0;  ///< sum of dt l(x, u, t), all weights, masked or not [s]
  Times solve_us{};
  std::int64_t allocations_per_update = 0;            ///< most in one update
  std::array<std::int64_t, status_count> statuses{};  ///< updates by Status
  std::int64_t not_finite = 0;                        ///< samples with a state or an input that is not
  std::int64_t input_violations = 0;                  ///< components of the raw u beyond their limit in force
  std::int64_t applied_violations = 0;                ///< of the applied u
  double max_abs_input = 0.0;                         ///< of the raw u
  int pairs_active_max = 0;                           ///< most pairs of swarms in one update
  int pairs_left_out_max = 0;                         ///< most near ones without room in one update
  double min_distance = 0.0;                          ///< of a robot to any other body, all of the run [m]
  std::vector<Pair> pairs;
  std::vector<Idle> idle_observers;
  std::vector<Robot> robots;
  std::vector<Limit> limits;
  std::vector<Chatter> chatter;  ///< inputs that alternate at the period
  std::optional<std::vector<Drift>>
      drift;                           ///< robots that leave, the fastest first; none: not judged, too short
  std::vector<TriggeredEvent> events;  ///< but for changes of status, which the log has; at most 1000
};

/// Gathers SummaryValues. One thread.
class Summary {
 public:
  /// @param controllers  solver records in each sample
  Summary(const Scenario& scenario, std::size_t controllers);

  void add(const Sample& sample);

  SummaryValues values() const;
  /// summary.json, its keys as in docs/notation.md; what is not finite is null.
  std::string json() const;

  /// Samples with a state or an input, applied or raw, that is not finite; whether there is none.
  std::int64_t not_finite() const { return not_finite_; }
  bool finite() const { return not_finite_ == 0; }
  /// Components of applied inputs beyond the limits that were in force.
  std::int64_t applied_violations() const { return inputs_.beyond(); }
  /// Of the last sample: its stage cost, and the team as it was.
  double stage_cost() const { return stage_cost_; }
  const PresentTeam& present() const { return present_; }
  /// The time without a plan.
  const PlanSummary& plans() const { return plans_; }
  /// Of robots that are localized by view.
  const LocalizationSummary& localization() const { return localization_; }
  /// The hard distances, and what the barrier did.
  const SafetySummary& safety() const { return safety_; }
  /// Whether some observer did not see its target during all of the last 2 s.
  bool target_lost_at_end() const { return !out_of_view().empty(); }
  /// A sentence for each of them.
  std::vector<std::string> out_of_view() const;

 private:
  struct View {
    Observation pair;
    double nearest, farthest, angle_max;  // after settle [m], [rad]
    double out_since, in_since;           // begin of the present stretch [s]; NaN in the other
    std::int64_t settled = 0, seen = 0;   // samples after settle, and those of them in view
    bool in_force = true;
    TimeInForce time{};
    double angles = 0.0;        // sum after settle [rad]
    bool from_leaning = false;  // its plan is told
    PlannedView planned{};
  };
  struct Limit {
    std::string name;
    Potential potential;
    BodyId a, b;
    double broken_since;  // [s]; NaN while it holds
    BodyId third{};       // that it looks past; index -1: none
    double longest = 0.0, worst = 0.0;
    std::int64_t broken = 0, counted = 0;
    bool in_force = true;
    TimeInForce time{};
  };
  struct Robot {
    BodyId body;
    TrackingError error;
    bool leans = false;     // its tilt is told
    double steepest = 0.0;  // tangent of the largest tilt
    PlannedTilt planned{};
    bool is_idle = false;  // asked to observe, and nobody is there
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
  std::vector<Sight<double>> sights_;  // of all bodies at the present sample
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

/// One line of the summary as a person reads it.
struct SummaryLine {
  std::string what, value;
};

/// summary.json in words and units.
/// @throws std::runtime_error where the text is no such summary
std::vector<SummaryLine> summary_lines(std::string_view json);

/// How planned and flown compare, in words and units, for pairs and robots that lean: what it is, as planned, as flown, and root
/// mean square of the difference.
/// @throws std::runtime_error where the text is no such summary
std::vector<std::array<std::string, 4>> planned_rows(std::string_view json);

/// Solvers side by side: a line for each summary.json, with its times to solve and its cost.
/// @throws std::runtime_error where a text is no such summary
std::vector<SummaryLine> comparison_lines(std::span<const std::string> summaries);

/// partition.json in words; no line where it is not of the run that the summary tells.
/// @throws std::runtime_error where a text is no such file
std::vector<SummaryLine> partition_lines(std::string_view summary, std::string_view partition);

/// Writes summary.json into the folder, whole or not at all.
/// @return what went wrong, a sentence; empty if it stands there
std::string write_summary(const std::filesystem::path& folder, std::string_view json);

}  // namespace sightline
