#include <algorithm>
#include <condition_variable>
#include <exception>
#include <list>
#include <map>
#include <mutex>

#include "sightline/analysis.hpp"
#include "sightline/base.hpp"
#include "sightline/judge/run_evaluator.hpp"

namespace sightline {
namespace {

/// Passes runs that end in any order on in the order of their indices.
class Order {
 public:
  using Landed = std::function<void(const RunDraw&, const RunResult&)>;
  Order(const Landed& landed, int first) : landed_(landed), first_(first), next_(first) {}

  /// Blocks while too many runs wait, which bounds the memory.
  /// @param index  of a run to fly
  void land(int index, RunDraw run, const RunResult& result) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [&] { return kept_.size() < kept_max || index == next_ || failure_; });
    if (failure_) return;
    kept_.emplace(index, std::pair(std::move(run), result));
    try {
      for (auto first = kept_.begin(); first != kept_.end() && first->first == next_; first = kept_.begin()) {
        landed_(first->second.first, first->second.second);
        kept_.erase(first);
        ++next_;
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    room_.notify_all();
  }

  void fail(std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
    room_.notify_all();
  }

  bool failed() {
    const std::lock_guard lock(mutex_);
    return failure_ != nullptr;
  }

  /// Number of runs passed on; only after all threads have ended.
  int end() const {
    if (failure_) std::rethrow_exception(failure_);
    return next_ - first_;
  }

 private:
  static constexpr std::size_t kept_max = 256;
  const Landed& landed_;
  std::mutex mutex_;
  std::condition_variable room_;
  std::map<int, std::pair<RunDraw, RunResult>> kept_;
  int first_, next_;
  std::exception_ptr failure_;
};

}  // namespace

Controls& RunWorker::controls_of(const RunDraw& run, const Scenario& scenario) {
  std::vector<double> values = variants_.team_values(run);
  const auto known = std::find_if(controls_.begin(), controls_.end(),
                                  [&](const auto& controls) { return controls.first == values; });
  if (known != controls_.end()) {
    if (known->second->restart()) return *known->second;
    controls_.erase(known);
  }
  if (controls_.size() == solvers_max) controls_.erase(controls_.begin());
  return *controls_.emplace_back(std::move(values), std::make_unique<Controls>(scenario)).second;
}

RunResult RunWorker::fly(const RunDraw& run) {
  Scenario scenario = variants_.flight(run);
  scenario.log.prediction_period = 0;
  Controls& controls = controls_of(run, scenario);
  const Controllers controllers = controls.controllers();
  SimulatedClock clock;
  const auto world = make_world(scenario);
  RunEvaluator judge(scenario, plan_, sized_sample(*world, controllers, controls.team_switcher()));
  ClosedLoop loop(scenario, *world, controllers, clock, judge, nullptr, controls.team_switcher());
  const LoopOutcome outcome = loop.fly();
  return judge.result(outcome, outcome.finite ? std::string() : world->ended());
}

const CampaignPlan& campaign_plan(const Scenario& scenario) {
  if (scenario.campaign_refusal) throw *scenario.campaign_refusal;
  if (scenario.campaign) return *scenario.campaign;
  throw_invalid("{}:1: campaign is missing, expected [campaign] with what is drawn", scenario.file.native());
}

void check_campaign(const Scenario& scenario, const CampaignPlan& plan) { Variants(scenario, plan); }

int fly_campaign(const Scenario& scenario, const CampaignPlan& plan, const CampaignOptions& options,
                 const std::function<void(const RunDraw&, const RunResult&)>& landed) {
  const Variants variants(scenario, plan);
  Order order(landed, options.first);
  std::atomic<int> next{options.first};
  const auto work = [&] {
    try {
      RunWorker pilot(variants, plan);
      const auto stopped = [&] { return options.stop != nullptr && options.stop->load(); };
      const int size = options.shard.size(options.runs);
      for (int i = next++; i < size && !order.failed() && !stopped(); i = next++) {
        const int index = options.shard.run(i);
        RunDraw run = options.draw ? options.draw(index) : draw_run(plan, options.seed, index);
        const RunResult result = pilot.fly(run);
        order.land(i, std::move(run), result);
      }
    } catch (...) {
      order.fail(std::current_exception());
    }
  };
  {
    std::list<ServiceThread> threads;  // if some fail to start, the others fly all runs
    for (int i = 1; i < options.threads; ++i) threads.emplace_back("a thread of the campaign", work);
    work();
  }
  return order.end();
}

}  // namespace sightline
