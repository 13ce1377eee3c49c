#include "bridges/dds/fleet/loop_timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/base/quantile.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

constexpr double missed_most = 0.02;  // of the periods

/// A steady clock that records the wake-up delay and the working time of each period.
class TimedClock final : public Clock {
 public:
  explicit TimedClock(std::size_t periods) {
    woken_late_.reserve(periods);
    at_work_.reserve(periods);
  }

  void start(double period) noexcept override {
    period_ = period;
    clock_.start(period);
    begin_ = Time::now();
  }
  std::int64_t wait(std::int64_t k) noexcept override {
    if (k > 0) note(at_work_, Time::now() - woken_);
    const std::int64_t runs = clock_.wait(k);
    woken_ = Time::now();
    const std::chrono::duration<double> due(static_cast<double>(k) * period_);
    if (runs == k) note(woken_late_, woken_ - begin_ - due);
    return runs;
  }
  bool waits_for_log() const noexcept override { return false; }

  const std::vector<double>& woken_late() const { return woken_late_; }
  const std::vector<double>& at_work() const { return at_work_; }

 private:
  using Time = std::chrono::steady_clock;

  // Never exceeds the reserved capacity: nothing is allocated in flight.
  static void note(std::vector<double>& times, std::chrono::duration<double> time) noexcept {
    if (times.size() < times.capacity()) times.push_back(time.count());
  }

  SteadyClock clock_;
  double period_ = 0.0;
  Time::time_point begin_{}, woken_{};
  std::vector<double> woken_late_, at_work_;
};

struct NoLog final : Sink<Sample> {
  explicit NoLog(Sample prototype) : sample(std::move(prototype)) {}
  Sample* claim() noexcept override { return &sample; }
  void publish() noexcept override {}
  void close() noexcept override {}
  Sample sample;
};

}  // namespace

Finding LoopTiming::finding() const {
  const double share = static_cast<double>(missed) / static_cast<double>(std::max<std::int64_t>(periods, 1));
  const bool late = share > missed_most || update_p99 > period;
  return {"", Aspect::timing, late ? Light::red : Light::green,
          fmt::format(
              "{} periods of {:g} ms: updates take {:.2f} ms, p99 {:.2f} ms, at most {:.2f} ms; woken "
              "{:.2f} ms late at p99; {:.1f} % missed{}; {}",
              periods, 1e3 * period, 1e3 * update_median, 1e3 * update_p99, 1e3 * update_most, 1e3 * wake_p99,
              100 * share,
              late ? fmt::format(", expected at most {:g} %, and updates within a period", 100 * missed_most)
                   : "",
              realtime.sentence())};
}

LoopTiming time_loop(Scenario scenario, double seconds, const std::atomic<bool>* stop) {
  scenario.world = "model";
  scenario.simulation.duration = seconds;
  scenario.simulation.faults.clear();
  scenario.simulation.late_plans.clear();
  lift_deadline(scenario.solver);  // as in a flight
  const auto world = make_world(scenario);
  const Controls controls(scenario);
  TimedClock clock(static_cast<std::size_t>(std::ceil(seconds / scenario.horizon.dt)) + 1);
  NoLog log(sized_sample(*world, controls.controllers(), controls.team_switcher()));
  ClosedLoop loop(scenario, *world, controls.controllers(), clock, log, nullptr, controls.team_switcher(),
                  stop);
  LoopTiming timing;
  LoopOutcome outcome;
  run_apart([&] {
    timing.realtime = become_realtime(control_priority);
    outcome = loop.fly();
  });
  timing.period = scenario.horizon.dt;
  timing.periods = outcome.updates + outcome.missed;
  timing.missed = outcome.missed;
  timing.update_median = quantile(clock.at_work(), 0.5);
  timing.update_p99 = quantile(clock.at_work(), 0.99);
  timing.update_most = quantile(clock.at_work(), 1.0);
  timing.wake_p99 = quantile(clock.woken_late(), 0.99);
  return timing;
}

}  // namespace sightline
