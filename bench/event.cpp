#include "bench/event.hpp"

#include <algorithm>
#include <chrono>

#include "sightline/loop.hpp"
#include "sightline/run/controller.hpp"
#include "tests/support/event_team.hpp"
#include "tests/support/team_flight.hpp"

namespace sightline {

std::vector<BenchRow> run_event_bench(const BenchOptions& options) {
  using Time = std::chrono::steady_clock;
  constexpr int robots = 8, leaders = 2;
  const Team world = event_team(robots, leaders);
  const AgentId turning{BodyId{leaders}};
  const auto turn = [&](const char* from, const char* to, BodyId target) {
    return TeamEvent{.name = to,
                     .trigger = AfterTime{0.5},
                     .actions = {Observe{turning, target}},
                     .stage = from,
                     .enter = to,
                     .ramp = 0.3};
  };
  const Script script{{turn("start", "there", BodyId{0}), turn("there", "start", BodyId{1})}};
  TeamSwitcher team_switcher(ActiveTeam(world), script, newton_riccati_of(bench_horizon));
  Plant plant(world, event_start(world, leaders));
  std::vector<double> u(static_cast<std::size_t>(world.nu()));
  std::vector<double> all, after, changes;
  for (std::vector<double>* times : {&all, &after, &changes})
    times->reserve(static_cast<std::size_t>(options.updates));
  ValidStates states(world, plant.x());
  std::vector<double> stamps(static_cast<std::size_t>(world.bodies()));
  int since = 1000, changed = 0;
  std::int64_t allocations = 0;
  const auto count = [&] { return options.allocations == nullptr ? 0 : options.allocations(); };
  for (int k = 0; k < options.updates; ++k) {
    const double t = bench_horizon.dt * k;
    const std::int64_t before = count();
    while (!team_switcher.is_ready()) std::this_thread::yield();
    std::fill(stamps.begin(), stamps.end(), t);
    (void)states.take(plant.x(), stamps);
    const Time::time_point begin = Time::now();
    const bool swapped = team_switcher.swap(t, states, u, true);
    const double swap_us = std::chrono::duration<double, std::micro>(Time::now() - begin).count();
    if (swapped) changes.push_back(swap_us), since = 0, ++changed;
    Controller& controller = *team_switcher.present().controller;
    controller.gather(world, states, u);
    const Solution solution = controller.solver->solve(t, controller.states);
    std::copy(solution.u.begin(), solution.u.end(), u.begin());
    if (k > 0) all.push_back(1e6 * solution.elapsed);
    if (since++ < 3) after.push_back(1e6 * solution.elapsed);
    team_switcher.look(t, states, u, {});
    team_switcher.clear_events();
    allocations = std::max(allocations, count() - before);
    (void)plant.step(u, bench_horizon.dt);
  }
  if (options.progress) options.progress(changed);
  std::vector<BenchRow> rows = {row_of(event_case_name, robots, all), row_of("events_8_after", robots, after),
                                row_of("events_8_swap", robots, changes)};
  for (BenchRow& row : rows) row.allocations = allocations;
  return rows;
}

}  // namespace sightline
