/// Monte Carlo runs of one scenario, each with its own draws, on all cores.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "sightline/campaign/shard.hpp"
#include "sightline/campaign/variant.hpp"
#include "sightline/judge/run_evaluator.hpp"
#include "sightline/scenario/closed_loop.hpp"

namespace sightline {

struct CampaignOptions {
  int runs = 100;          ///< >= 1
  std::uint64_t seed = 1;  ///< with an index, it determines all draws of a run
  int threads = 1;         ///< >= 1
  int first = 0;           ///< so many of the shard's runs are known already
  Shard shard{};           ///< which of the runs
  /// Ends the campaign after the present runs, once it is true.
  const std::atomic<bool>* stop = nullptr;
};

/// Flies runs one after another, in one thread, with solvers that are made once.
class RunWorker {
 public:
  /// @param variants  outlives this
  RunWorker(const Variants& variants, const CampaignPlan& plan) : variants_(variants), plan_(plan) {}

  /// @throws ScenarioError where a number drawn is refused
  RunResult fly(const RunDraw& run);

 private:
  Controls& controls_of(const RunDraw& run, const Scenario& scenario);

  static constexpr std::size_t solvers_max = 8;
  const Variants& variants_;
  CampaignPlan plan_;
  std::vector<std::pair<std::vector<double>, std::unique_ptr<Controls>>> controls_;  // the oldest first
};

/// What the scenario draws.
/// @throws std::invalid_argument where it has no [campaign], ScenarioError where that cannot be flown
const CampaignPlan& campaign_plan(const Scenario& scenario);

/// @throws ScenarioError where the scenario cannot be judged over many runs of the plan, as Variants
void check_campaign(const Scenario& scenario, const CampaignPlan& plan);

/// Flies the runs of options.shard that are not known yet, those below options.runs, and hands them over in this order, one at a time.
/// @param landed  called by one thread at a time; what it throws ends the campaign
/// @return runs handed over
/// @throws ScenarioError where a number drawn is refused, with the run
int fly_campaign(const Scenario& scenario, const CampaignPlan& plan, const CampaignOptions& options,
                 const std::function<void(const RunDraw&, const RunResult&)>& landed);

}  // namespace sightline
