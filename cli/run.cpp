#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "cli/allocations.hpp"
#include "cli/commands.hpp"
#include "cli/linked_sink.hpp"
#include "cli/output.hpp"
#include "cli/partition.hpp"
#include "cli/progress.hpp"
#include "sightline/record/folder_lock.hpp"
#include "sightline/record/log.hpp"
#include "sightline/record/planned_view.hpp"
#include "sightline/report/report.hpp"
#include "sightline/run/realtime.hpp"
#include "sightline/scenario/closed_loop.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline::cli {
namespace {

/// Samples that may wait for the log: a second of flight at 100 Hz and more, within this much memory.
std::size_t ring_capacity(const Sample& sample) {
  constexpr std::size_t memory = 256'000'000;  // bytes
  const std::size_t numbers =
      2 * sample.x.size() + 2 * sample.u.size() + sample.path.size() + sample.path_u.size();
  return std::clamp<std::size_t>(memory / (sizeof(Sample) + sizeof(double) * numbers), 8, 1024);
}

Scenario read(const RunOptions& options, const Parts& parts) {
  Scenario scenario = options.scenario.read(parts);
  if (options.seed) scenario.simulation.seed = *options.seed;
  // The scenario's own options hold for its own solver.
  if (options.solver && *options.solver != scenario.solver.name)
    scenario.solver = solver_named(*options.solver);
  std::erase(scenario.simulation.compare, scenario.solver.name);
  if (!options.realtime) lift_deadline(scenario.solver);
  check_solvers(scenario);
  return scenario;
}

void print_table(const std::vector<SummaryLine>& lines) {
  std::size_t width = 0;
  for (const SummaryLine& line : lines) width = std::max(width, line.what.size());
  for (const SummaryLine& line : lines) print("{:{}}  {}\n", line.what, width, line.value);
}

/// What makes a run a failure, a sentence each.
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

/// What a flight left, beside its files.
struct Flight {
  std::string summary;
  std::vector<std::string> faults;
  bool logged;  // its files are whole
};

/// From the ground to the ground, by a thread of its own: what it asks of the machine is for no one else.
LoopOutcome fly_linked(LinkedFlight& linked, ClosedLoop& loop, Sink<Sample>& sink) {
  LoopOutcome outcome;
  std::thread([&] {
    const TellPerson tell = [](std::string_view sentence) {
      offer_message(fmt::format("sightline: {}\n", sentence));
    };
    tell(become_realtime(control_priority).sentence());
    if (linked.world.take_off(linked.arming, linked.interrupts, tell)) {
      outcome = loop.fly();
      linked.world.land(linked.interrupts, tell);
    } else {
      sink.close();
    }
  }).join();
  return outcome;
}

/// A summary that says how a flight on links kept time as well.
std::string with_timing(const std::string& summary, const LinkTiming& timing) {
  using Ordered = nlohmann::ordered_json;
  const auto us = [](const LinkTiming::Delay& delay) {
    return Ordered{{"median", 1e6 * delay.median}, {"p99", 1e6 * delay.p99}, {"max", 1e6 * delay.most}};
  };
  Ordered json = Ordered::parse(summary);
  json["real_time"] = {{"periods", timing.periods},
                       {"missed", timing.missed},
                       {"wake_us", us(timing.wake)},
                       {"arrival_us", us(timing.arrival)},
                       {"cpu", timing.cpu}};
  return json.dump(2, ' ', false, Ordered::error_handler_t::replace) + "\n";
}

/// Flies the scenario under its controllers; leaves run.mcap, timing.csv and summary.json in the folder.
Flight fly_logged(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                  const ShowOptions& view, const Controllers& controllers,
                  TeamSwitcher* team_switcher = nullptr, const McapWords& flown = {},
                  LinkedFlight* linked = nullptr) {
  // All memory is taken here, before the first period.
  const auto simulated = linked == nullptr ? make_world(scenario) : nullptr;
  World& world = linked == nullptr ? *simulated : linked->world;
  Sample prototype = sized_sample(world, controllers);
  make_room_for_plans(scenario, prototype);
  Ring<Sample> ring(ring_capacity(prototype), prototype);
  std::optional<LinkedSink> shown;
  if (linked != nullptr) shown.emplace(ring, linked->world, linked->stop);
  Sink<Sample>& kept = shown ? static_cast<Sink<Sample>&>(*shown) : ring;
  std::optional<FlightPage> page;
  std::optional<ShownSink> watched;
  if (view.show) {
    page.emplace(scenario, prototype, view.serve);
    watched.emplace(kept, *page);
    tell_without_page();
    say(fmt::format("the page is {}", page->url()));
  }
  Sink<Sample>& sink = watched ? static_cast<Sink<Sample>&>(*watched) : kept;
  ClosedLoop loop(scenario, world, controllers, clock, sink, allocations, team_switcher,
                  linked != nullptr ? &linked->stop : nullptr);

  Progress progress(scenario.simulation.duration);
  Log log(
      scenario, folder, controllers, ring, [&](double time) { progress.show(time); }, flown);
  log.start();
  const LoopOutcome outcome = linked != nullptr ? fly_linked(*linked, loop, sink) : loop.fly();
  log.finish();
  progress.end();

  std::string summary = log.summary().json();
  if (linked != nullptr) summary = with_timing(summary, linked->world.timing());
  Flight flight = {std::move(summary), faults_of(outcome, world, log), log.error().empty()};
  if (shown && shown->too_old())
    flight.faults.emplace_back("what was known of a robot grew too old: all landed");
  // Beside an earlier log stands its own summary.
  std::string lost = log.begun() ? write_summary(folder, flight.summary) : "";
  if (!lost.empty()) {
    flight.faults.push_back(std::move(lost));
    flight.logged = false;
  }
  return flight;
}

Flight fly_logged(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                  const ShowOptions& view, LinkedFlight* linked) {
  const Controls controls(scenario);
  if (const std::string told = controls.kernels().sentence(); !told.empty()) say(told);
  return fly_logged(scenario, folder, clock, view, controls.controllers(), controls.team_switcher(), {},
                    linked);
}

}  // namespace

RunFolder::RunFolder(const std::filesystem::path& folder, const Scenario& scenario, bool in_parts) {
  const auto& compare = scenario.simulation.compare;
  std::vector<std::filesystem::path> folders = {folder};
  // Of comparisons, those too that an earlier flight left, whose summaries go.
  const auto add = [&](std::string_view name, bool needed) {
    if (needed || std::filesystem::is_directory(folder / name)) folders.push_back(folder / name);
  };
  for (const std::string_view name : solver_names())
    add(name, std::find(compare.begin(), compare.end(), name) != compare.end());
  add("whole", in_parts);
  for (const std::filesystem::path& one : folders)
    locks_.emplace_back(one, std::initializer_list<std::string_view>{"run.mcap", "timing.csv", "summary.json",
                                                                     "report.html", "partition.json"});
}

int run(const RunOptions& options, const Parts& parts) {
  Scenario scenario;
  std::optional<PartitionChoice> partition;
  std::optional<RunFolder> folder;
  try {
    scenario = read(options, parts);
    if (options.partition)
      partition = read_partition(scenario, *options.partition, options.order, options.exchanges);
    folder.emplace(options.output.empty() ? std::filesystem::path("out") / scenario.name : options.output,
                   scenario, partition.has_value());
  } catch (const std::exception& error) {
    tell("{}\n", error.what());
    return 2;
  }
  outlive_the_terminal();
  SimulatedClock simulated;
  SteadyClock steady;
  try {
    return fly(std::move(scenario), *folder, options.realtime ? static_cast<Clock&>(steady) : simulated,
               options.view, partition ? &*partition : nullptr);
  } catch (const std::invalid_argument& error) {  // of what is built before the flight
    tell("{}: {}\n", options.scenario.file.native(), error.what());
    return 2;
  }
}

int fly(Scenario scenario, const RunFolder& run_folder, Clock& clock, const ShowOptions& view,
        const PartitionChoice* partition, LinkedFlight* linked) {
  const std::filesystem::path& folder = run_folder.path();
  std::optional<PartitionedFlight> parts;
  SolverChoice of_whole = scenario.solver;
  if (partition != nullptr) {
    parts.emplace(scenario, *partition);
    lift_deadline(of_whole);
    scenario.solver.name = parts->name();
  }
  const Flight flight = parts ? fly_logged(scenario, folder, clock, view, {*parts}, nullptr,
                                           {{"partition", partition->text},
                                            {"order", std::string(to_string(partition->order))},
                                            {"exchanges", fmt::format("{}", partition->exchanges)}})
                              : fly_logged(scenario, folder, clock, view, linked);
  for (const std::string& fault : flight.faults) say(fault);
  bool bad = !flight.faults.empty();

  std::vector<std::string> summaries = {flight.summary};
  std::string of_parts;
  if (parts && flight.logged) {
    SimulatedClock simulated;
    scenario.solver = of_whole;
    const Flight whole = fly_logged(scenario, folder / "whole", simulated, {}, nullptr);
    for (const std::string& fault : whole.faults) say(fmt::format("the whole team by one solver: {}", fault));
    bad = bad || !whole.logged;
    summaries.push_back(whole.summary);
    of_parts = parts->tell(folder, flight.summary, whole.summary);
  }
  for (const std::string& name : scenario.simulation.compare) {
    if (!flight.logged) break;
    SimulatedClock simulated;
    scenario.solver = solver_named(name);
    const Flight other = fly_logged(scenario, folder / name, simulated, {}, nullptr);
    for (const std::string& fault : other.faults) say(fmt::format("compared with {}: {}", name, fault));
    bad = bad || !other.logged;
    summaries.push_back(other.summary);
  }

  if (flight.logged) {
    try {
      write_report(folder);
    } catch (const std::exception& error) {
      say(error.what());
      bad = true;
    }
  }
  print_table(summary_lines(flight.summary));
  if (summaries.size() > 1) {
    print("\n");
    print_table(comparison_lines(summaries));
    print("\n");
  }
  if (!of_parts.empty()) {
    print("{}\n", of_parts);
    print("{}\n", (folder / "partition.json").native());
  }
  // A report without gnuplot, or a log on a full disk, is not there.
  for (const char* file : {"report.html", "run.mcap", "summary.json"})
    if (std::error_code error; std::filesystem::exists(folder / file, error))
      print("{}\n", (folder / file).native());
  return bad ? 1 : 0;
}

int report(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) {
    tell("{}: not a folder, expected the folder of a run\n", folder.native());
    return 2;
  }
  if (!std::filesystem::is_regular_file(folder / "run.mcap")) {
    tell("{}: no run.mcap, expected the folder of a run\n", folder.native());
    return 2;
  }
  std::optional<FolderLock> lock;
  try {
    lock.emplace(folder, std::initializer_list<std::string_view>{"run.mcap", "timing.csv", "summary.json",
                                                                 "report.html"});
  } catch (const std::invalid_argument& error) {
    tell("{}\n", error.what());
    return 2;
  }
  try {
    write_report(folder);
  } catch (const std::exception& error) {
    say(error.what());
    return 1;
  }
  print("{}\n", (folder / "report.html").native());
  return 0;
}

}  // namespace sightline::cli
