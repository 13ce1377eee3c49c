/// Flights of a team that changes, as the loop flies them, kept in memory.
#pragma once

#include <functional>
#include <vector>

#include "sightline/loop.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/sample_sink.hpp"
#include "tests/support/valid.hpp"

namespace sightline {

/// What one period left.
struct FlownPeriod {
  double time = 0.0;
  std::vector<double> x, u;
  std::vector<Presence> presence;
  SolverRecord solver;
  double kkt = 0.0;
  std::vector<Event> events;
};

/// Keeps all samples; the loop is never held up.
class KeepSamples final : public test::SampleSink {
 public:
  using SampleSink::SampleSink;
  void publish() noexcept override {
    flown.push_back({sample_.time,
                     sample_.x,
                     sample_.u,
                     sample_.presence,
                     sample_.solvers[0],
                     0.0,
                     {sample_.events.begin(), sample_.events.begin() + sample_.event_count}});
    if (after) after(flown.back());
  }

  std::vector<FlownPeriod> flown;
  std::function<void(FlownPeriod&)> after;
};

/// Evaluates the optimality of each update, outside of it.
inline void evaluate_kkt(KeepSamples& sink, const Team& all, TeamSwitcher& team_switcher) {
  std::vector<double> u_before(static_cast<std::size_t>(all.nu()));
  sink.after = [&all, &team_switcher, u_before](FlownPeriod& period) mutable {
    Controller& controller = *team_switcher.present().controller;
    controller.gather(all, test::valid(all, period.x), u_before);  // as the update saw it
    u_before = period.u;
    period.kkt = team_switcher.present().solver->kkt(period.time, controller.states);
  };
}

struct TeamFlight {
  std::vector<FlownPeriod> flown;
  LoopOutcome outcome;
};

/// @param with_kkt  evaluates the optimality of each update, outside of it
inline TeamFlight fly_script(const Team& all, const std::vector<double>& x0, const Script& script,
                             double duration, std::vector<Presence> presence = {}, bool with_kkt = false,
                             std::vector<TimedSignal> signals = {},
                             MakeSolver make = newton_riccati_of(Horizon{})) {
  const Horizon horizon;
  TeamSwitcher team_switcher(ActiveTeam(all, std::move(presence)), script, std::move(make));
  ModelWorld world(all, x0, {.period = horizon.dt}, {.period = horizon.dt});
  SimulatedClock clock;
  const Controllers controllers = {*team_switcher.present().solver};
  KeepSamples sink(sized_sample(all, controllers, &team_switcher));
  if (with_kkt) evaluate_kkt(sink, all, team_switcher);
  Loop loop(world, controllers, clock, sink,
            {.duration = duration,
             .period = horizon.dt,
             .path_interval = 0.0,
             .team_switcher = &team_switcher,
             .signals = std::move(signals)});
  TeamFlight flight;
  flight.outcome = loop.run();
  flight.flown = std::move(sink.flown);
  return flight;
}

}  // namespace sightline
