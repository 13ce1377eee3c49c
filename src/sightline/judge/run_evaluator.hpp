/// The outcome of one run.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/no_value.hpp"
#include "sightline/judge/drift.hpp"
#include "sightline/judge/input_record.hpp"
#include "sightline/judge/localization_summary.hpp"
#include "sightline/judge/plan_summary.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/judge/safety_summary.hpp"
#include "sightline/judge/tracking_error.hpp"
#include "sightline/run/loop.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// The first of failed, too_close and lost that holds, or else recovered.
enum class Outcome : std::uint8_t {
  recovered,  ///< every observer saw its target in time and sees it at the end
  lost,       ///< one did not
  too_close,  ///< a robot came nearer to another body than d_hard, although it could have braked at the start
  failed,  ///< a state or an input was not finite, an applied input was beyond its limit, a solver gave no plan for
  ///< longer than hold_after, a floor, ceiling or bound of the world was broken, or the run broke off
};
inline constexpr int outcome_count = 4;

std::string_view to_string(Outcome outcome);

/// Of one robot in a run, as in summary.json.
struct RobotResult {
  double energy = 0.0;                   ///< sum of dt u'Ru of the applied inputs [s]
  double rms_position_error = no_value;  ///< from rms_from on [m]
  double rms_heading_error = no_value;   ///< from rms_from on [rad]
};

/// A run's row in the table; not a number: there was nothing to compute it from, or it never came.
struct RunResult {
  Outcome outcome = Outcome::failed;
  double min_distance = 0.0;  ///< of a robot to any other body, all of the run [m]
  double time_to_first_view =
      0.0;                        ///< until each observer had seen its target once, since it was asked to [s]
  double fraction_in_view = 0.0;  ///< of the run, all observers at once, those that are asked to then
  bool could_brake = true;        ///< at the start, all pairs in time for d_hard
  std::int64_t violations = 0;  ///< periods with an input beyond its limit, or nearer than d_hard where that
                                ///< could be kept
  std::array<std::int64_t, status_count> statuses{};
  double energy = 0.0;                ///< sum of dt u'Ru of the applied inputs, all robots [s]
  std::vector<RobotResult> robots{};  ///< in the order of the team
  double chatter = 0.0;  ///< largest share of the time in which an input alternated at the period
  /// Greatest steady speed at which a robot moved away from its task at the end [m/s]; 0: none did; not a number:
  /// the run was too short to judge.
  double drift = 0.0;
  double longest_without_plan = 0.0;  ///< of all solvers, whatever the reason [s]; 0: each update gave one
  /// Largest share of the time in which the barrier found no command that keeps a robot's distances and walls; not a number
  /// without a barrier.
  double barrier_conflict = 0.0;
  double longest_out_of_view = 0.0;  ///< that an observer did not see its target, once it had [s]
  std::vector<RobotLocalization> localizations{};  ///< of the robots that are localized by vision
  std::string reason{};  ///< of a failed run: the sentence of what went wrong first; else empty
};

/// Takes the samples of a loop and judges them as they come; keeps none. Of a team that changes in flight those are judged that
/// are there, by the couplings and limits in force. The hard distance of a pair is that of
/// the scenario's [safety], or else of its [campaign].
class RunEvaluator final : public Sink<Sample> {
 public:
  /// @param sample  of sized_sample()
  RunEvaluator(const Scenario& scenario, const CampaignPlan& plan, Sample sample);
  RunEvaluator(const RunEvaluator&) = delete;  // a loop writes into its sample
  RunEvaluator& operator=(const RunEvaluator&) = delete;

  Sample* claim() noexcept override { return &sample_; }
  bool takes_between() const noexcept override { return true; }
  Sample* claim_between() noexcept override { return &sample_; }
  /// Where a sample cannot be judged, as where there is no memory, none after it is.
  void publish() noexcept override;
  void close() noexcept override {}

  /// @param ended  why the world ended the flight, a sentence; empty where it did not
  /// @throws what kept a sample from being judged
  RunResult result(const LoopOutcome& outcome, std::string ended = {}) const;

 private:
  static constexpr double never = std::numeric_limits<double>::infinity();
  struct View {
    Observation pair;
    bool requested = false;                           // now
    bool seen = false;                                // in the last sample
    double since = 0.0, first = never, last = never;  // that it is asked, and seen [s]
    double waited = 0.0;                              // for the first sight, when it was asked before [s]

    double wait() const { return requested ? std::max(waited, first - since) : waited; }
  };

  struct Robot {
    BodyId body;
    TrackingError error;
  };

  enum class Fault : std::uint8_t { none, not_finite, input, no_plan };

  void judge();
  void blame(Fault fault) noexcept;
  /// Empty where nothing failed. @param whole  the loop flew to the end of the run
  std::string reason(std::string ended, bool whole) const;
  bool follow();
  void look() noexcept;

  const Team& team_;
  CampaignPlan plan_;
  double period_, hold_after_;  // [s]
  SafetySummary safety_;
  LocalizationSummary localization_;
  bool changes_;  // in flight
  PresentTeam present_;
  Sample sample_;
  std::vector<View> views_;
  std::vector<Robot> robots_;
  std::vector<Sight<double>> sights_;
  std::vector<double> u_rest_;
  InputRecord inputs_;
  Drift drift_;

  std::int64_t updates_ = 0, seen_ = 0;
  std::vector<PlanGaps> gaps_;  // of each solver
  Fault fault_ = Fault::none;   // the first
  double fault_time_ = 0.0;     // [s]
  RunResult result_;
  std::exception_ptr failure_;  // of judge()
};

}  // namespace sightline
