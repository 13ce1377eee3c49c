#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <memory>
#include <string_view>
#include <utility>

#include "sightline/judge/planned_view.hpp"
#include "sightline/log.hpp"
#include "sightline/record/log.hpp"

namespace sightline {
namespace {

/// Capacity of the queue to the log: at least a second of flight at 100 Hz, and more within less
/// memory; of large teams what fits into the memory.
std::size_t ring_capacity(const Sample& sample) {
  constexpr std::size_t memory = 64'000'000, memory_of_second = 256'000'000, second = 128;  // [B], samples
  const std::size_t numbers =
      2 * sample.x.size() + 2 * sample.u.size() + sample.path.size() + sample.path_u.size();
  const std::size_t size = sizeof(Sample) + sizeof(double) * numbers;
  return std::clamp<std::size_t>(memory / size, std::clamp<std::size_t>(memory_of_second / size, 8, second),
                                 1024);
}

/// Reasons why a run failed, one sentence each.
std::vector<std::string> faults_of(const LoopOutcome& outcome, const World& world, const Log& log) {
  std::vector<std::string> faults = log.summary().out_of_view();
  for (std::string& sentence : log.summary().plans().failures()) faults.push_back(std::move(sentence));
  for (std::string& sentence : log.summary().safety().broken()) faults.push_back(std::move(sentence));
  std::string ended = outcome.finite ? "" : world.ended();
  if ((!outcome.finite && ended.empty()) || log.summary().not_finite() > 0)
    faults.emplace_back("a state or an input was not finite");
  if (!ended.empty()) faults.push_back(std::move(ended));
  if (const std::int64_t beyond = log.summary().applied_violations(); beyond > 0)
    faults.push_back(fmt::format("{} applied inputs were beyond the limits in force", beyond));
  if (outcome.dropped > 0)
    faults.push_back(fmt::format("{} samples were lost, the log could not keep up", outcome.dropped));
  if (std::string lost = log.error(); !lost.empty()) faults.push_back(std::move(lost));
  return faults;
}

}  // namespace

RunFolder::RunFolder(const std::filesystem::path& folder, const Scenario& scenario, bool in_parts) {
  const auto& compare = scenario.simulation.compare;
  std::vector<std::filesystem::path> folders = {folder};
  // Also lock existing folders of earlier comparisons, because their summaries will be removed.
  const auto add = [&](std::string_view name, bool needed) {
    if (needed || std::filesystem::is_directory(folder / name)) folders.push_back(folder / name);
  };
  for (const std::string_view name : solver_names(registry_of(scenario)))
    add(name, std::find(compare.begin(), compare.end(), name) != compare.end());
  add("whole", in_parts);
  for (const std::filesystem::path& one : folders)
    locks_.emplace_back(one, std::initializer_list<std::string_view>{"run.mcap", "timing.csv", "summary.json",
                                                                     "report.html", "partition.json"});
}

LoggedFlight fly_logged(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                        const Controllers& controllers, const FlightOptions& options) {
  const auto simulated = options.world == nullptr ? make_world(scenario) : nullptr;
  World& world = options.world == nullptr ? *simulated : *options.world;
  Sample prototype = sized_sample(world, controllers, options.team_switcher);
  make_room_for_plans(scenario, prototype);
  const std::size_t capacity = ring_capacity(prototype);
  SpscQueue<Sample> ring(capacity, prototype, capacity / 2);
  Sink<Sample>& sink = options.watched ? options.watched(ring, prototype) : ring;
  ClosedLoop loop(scenario, world, controllers, clock, sink, options.allocations, options.team_switcher,
                  options.stop);

  McapWords flown = options.flown;
  if (world.absent_robots_stay()) flown.emplace(RecordedFlight::absent_stay, "true");
  Log log(scenario, folder, controllers, ring, options.written, flown);
  log.start();
  LoggedFlight flight;
  flight.outcome = options.fly ? options.fly(loop, sink) : loop.fly();
  log.finish();

  flight.summary = log.summary().json();
  if (options.summarised) flight.summary = options.summarised(std::move(flight.summary));
  flight.faults = faults_of(flight.outcome, world, log);
  flight.begun = log.begun();
  flight.logged = flight.begun && log.error().empty();
  // An earlier log keeps its own summary.
  std::string lost = flight.begun ? write_summary(folder, flight.summary) : "";
  if (!lost.empty()) {
    flight.faults.push_back(std::move(lost));
    flight.logged = false;
  }
  return flight;
}

}  // namespace sightline
