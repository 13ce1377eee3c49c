/// A flight that is tuned at given times: what somebody at a page does, by the clock of the
/// simulation.
#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "sightline/scenario.hpp"
#include "sightline/server/tuner.hpp"
#include "tests/support/sample_sink.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline::test {

struct TimedChange {
  double at;  ///< [s]
  std::string change;
};

struct FlownCommands {
  std::vector<std::vector<double>> u, x;  ///< of each period
  std::string flight, final;              ///< texts that it comes to
  std::vector<std::string> refusals{};

  /// The greatest step of an input from one period to the next, from `from` [s] on.
  double largest_step(double period, double from) const {
    double most = 0.0;
    for (std::size_t k = 1; k < u.size(); ++k) {
      if (static_cast<double>(k) * period < from) continue;
      for (std::size_t i = 0; i < u[k].size(); ++i) most = std::max(most, std::abs(u[k][i] - u[k - 1][i]));
    }
    return most;
  }
};

/// Takes each sample, and tunes between two periods.
class TuningSink final : public SampleSink {
 public:
  TuningSink(Sample prototype, Tuner* tuner, std::vector<TimedChange> changes, FlownCommands& flown)
      : SampleSink(std::move(prototype)), tuner_(tuner), changes_(std::move(changes)), flown_(flown) {}
  void publish() noexcept override {
    flown_.u.push_back(sample_.u);
    flown_.x.push_back(sample_.x);
    for (; next_ < changes_.size() && changes_[next_].at <= sample_.time + 1e-9; ++next_) {
      try {
        (void)tuner_->change(Tuner::Json::parse(changes_[next_].change), std::nan(""), sample_.time);
      } catch (const std::exception& error) {
        flown_.refusals.emplace_back(error.what());
      }
    }
  }

 private:
  Tuner* tuner_;
  std::vector<TimedChange> changes_;
  FlownCommands& flown_;
  std::size_t next_ = 0;
};

/// Flies it in simulated time.
/// @param tuned  whether changes may come, of which there may be none
inline FlownCommands fly_tuned(Scenario scenario, std::vector<TimedChange> changes, bool tuned = true) {
  scenario.simulation.compare.clear();
  lift_deadline(scenario.solver);
  if (tuned) make_tunable(scenario);
  FlownCommands flown;
  const auto tuner = tuned ? std::make_unique<Tuner>(scenario) : nullptr;
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  TuningSink sink(sized_sample(*world, controls.controllers(), controls.team_switcher()), tuner.get(),
                  std::move(changes), flown);
  SimulatedClock clock;
  (void)ClosedLoop(scenario, *world, controls.controllers(), clock, sink, nullptr, controls.team_switcher())
      .fly();
  if (tuned) flown.flight = tuner->flight_text(), flown.final = tuner->final_text();
  return flown;
}

/// The paper's pair with an obstacle, without events of its own.
inline std::string tuned_scenario(double duration) {
  return viewed_pair + R"toml(reference = { circle = { centre = [0.0, 0.0, 1.0], radius = 0.5, rate = 0.3 } }

[obstacle.post]
p = [4.0, 0.0, 1.0]

[[couple]]
name = "bearing"
potential = { bearing = { alpha = 0.5, width = 0.1, tilt = 0.2 } }
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 4.0

[[couple]]
potential = { keep_out = { d_min = 1.0 } }
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 0.4

[[couple]]
potential = { cohesion = { d_max = 2.0 } }
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 0.4

[simulation]
duration = )toml" +
         std::to_string(duration) + "\n";
}

}  // namespace sightline::test
