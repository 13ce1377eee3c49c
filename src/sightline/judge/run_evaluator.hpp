/// Evaluation of one run during its flight.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/judge.hpp"
#include "sightline/judge/drift.hpp"
#include "sightline/judge/input_record.hpp"
#include "sightline/judge/localization_summary.hpp"
#include "sightline/judge/plan_summary.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/judge/safety_summary.hpp"
#include "sightline/judge/tracking_error.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Evaluates the samples of a loop as they come, and keeps none. In a team that changes in flight
/// it evaluates the present bodies by the couplings and limits in force. The hard distance of a pair
/// is that of the scenario's [safety], or else that of its [campaign].
class RunEvaluator final : public Sink<Sample> {
 public:
  /// @param sample  of sized_sample()
  RunEvaluator(const Scenario& scenario, const CampaignPlan& plan, Sample sample);
  RunEvaluator(const RunEvaluator&) = delete;  // a loop writes into its sample
  RunEvaluator& operator=(const RunEvaluator&) = delete;

  Sample* claim() noexcept override { return &sample_; }
  bool takes_between() const noexcept override { return true; }
  Sample* claim_between() noexcept override { return &sample_; }
  /// After a sample that cannot be evaluated, for example for want of memory, later ones are ignored.
  void publish() noexcept override;
  void close() noexcept override {}

  /// @param ended  reason why the world ended the flight, as a sentence; empty if it did not
  /// @throws the exception that stopped the evaluation
  RunResult result(const LoopOutcome& outcome, std::string ended = {}) const;

 private:
  static constexpr double never = std::numeric_limits<double>::infinity();
  struct View {
    Observation pair;
    bool requested = false;  // at present
    bool seen = false;       // in the last sample
    double since = 0.0, first = never,
           last = never;           // time of the request, of the first and the last sight [s]
    double waited = 0.0;           // for the first sight after an earlier request [s]
    std::vector<double> recent{};  // values of the limit in the last `view_lost_after`, <= 0: in view
    std::size_t count = 0;         // of values since the first sight

    double wait() const { return requested ? std::max(waited, first - since) : waited; }
  };

  struct Robot {
    BodyId body;
    TrackingError error;
  };

  enum class Fault : std::uint8_t { none, not_finite, input, no_plan };

  void judge();
  void blame(Fault fault) noexcept;
  /// The first fault as a sentence, or empty. @param whole  the loop flew to the end of the run
  std::string reason(std::string ended, bool whole) const;
  bool follow();
  void look() noexcept;
  void look_at(View& view) noexcept;

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
  double view_margin_ = never;
  std::vector<PlanGaps> gaps_;  // of each solver
  Fault fault_ = Fault::none;   // the first
  double fault_time_ = 0.0;     // [s]
  RunResult result_;
  std::exception_ptr failure_;  // of judge()
};

}  // namespace sightline
