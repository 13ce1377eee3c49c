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
#include "sightline/judge/run_result.hpp"
#include "sightline/scenario/closed_loop.hpp"

namespace sightline {

struct CampaignOptions {
  int runs = 100;          ///< >= 1
  std::uint64_t seed = 1;  ///< with an index, determines all draws of a run
  int threads = 1;         ///< >= 1
  int first = 0;           ///< number of the shard's runs that are known already
  Shard shard{};           ///< the part of the runs to fly
  /// Ends the campaign after the runs in progress, once it is true.
  const std::atomic<bool>* stop = nullptr;
};

/// Flies runs one after another, in one thread, and reuses its solvers.
class RunWorker {
 public:
  /// @param variants  must outlive this object
  RunWorker(const Variants& variants, const CampaignPlan& plan) : variants_(variants), plan_(plan) {}

  /// @throws ScenarioError if a drawn number is refused
  RunResult fly(const RunDraw& run);

 private:
  Controls& controls_of(const RunDraw& run, const Scenario& scenario);

  static constexpr std::size_t solvers_max = 8;
  const Variants& variants_;
  CampaignPlan plan_;
  std::vector<std::pair<std::vector<double>, std::unique_ptr<Controls>>> controls_;  // oldest first
};

/// The draws of a scenario.
/// @throws std::invalid_argument if it has no [campaign], ScenarioError if its campaign cannot be
///   flown
const CampaignPlan& campaign_plan(const Scenario& scenario);

/// @throws ScenarioError if the scenario cannot be judged over many runs of the plan, as Variants
void check_campaign(const Scenario& scenario, const CampaignPlan& plan);

/// Flies the unknown runs of options.shard with an index below options.runs. Passes them to
/// `landed` in the order of their indices.
/// @param landed  called by one thread at a time; an exception of it ends the campaign
/// @return number of runs passed to `landed`
/// @throws ScenarioError with the run, if a drawn number is refused
int fly_campaign(const Scenario& scenario, const CampaignPlan& plan, const CampaignOptions& options,
                 const std::function<void(const RunDraw&, const RunResult&)>& landed);

}  // namespace sightline
