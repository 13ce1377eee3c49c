#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>

#include "cli/allocations.hpp"
#include "cli/arguments.hpp"
#include "cli/components.hpp"
#include "cli/linked_sink.hpp"
#include "cli/output.hpp"
#include "cli/partition.hpp"
#include "cli/progress.hpp"
#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/judge/summary_keys.hpp"
#include "sightline/log.hpp"
#include "sightline/report.hpp"
#include "sightline/run/realtime.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/file_kind.hpp"
#include "sightline/scenario/keys_without_effect.hpp"

namespace sightline::cli {
namespace {

struct RunOptions {
  NamedScenario scenario;
  std::filesystem::path output;
  std::optional<std::string> solver, partition;
  std::optional<std::uint64_t> seed;
  bool realtime = false;
  int threads = 1, exchanges = 1;
  ShowOptions view;
  std::string order = "gauss_seidel";
};

Scenario read(const RunOptions& options, const Registry& parts) {
  Scenario scenario = options.scenario.read(parts);
  if (options.seed) scenario.simulation.seed = *options.seed;
  // The scenario's options apply only to its own solver.
  if (options.solver && *options.solver != scenario.solver.name)
    scenario.solver = solver_named(*options.solver, parts);
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

/// Flies from take-off to landing on a separate thread, so that its real-time settings affect no
/// other thread.
LoopOutcome fly_linked(LinkedFlight& linked, ClosedLoop& loop, Sink<Sample>& sink) {
  LoopOutcome outcome;
  run_apart([&] {
    offer_sentence(become_realtime(control_priority).sentence());
    bool flies = true;  // if take-off fails halfway, some robots fly
    try {
      flies = linked.world.take_off(linked.arming, linked.interrupts, offer_sentence);
      if (flies) outcome = loop.fly();
    } catch (const std::exception& error) {
      print_sentence(sentence_of(error));
    }
    if (flies) linked.world.land(linked.interrupts, offer_sentence);
    sink.close();
  });
  return outcome;
}

/// Adds the timing of a flight on links to a summary.
std::string with_timing(const std::string& summary, const LinkTiming& timing) {
  using Ordered = nlohmann::ordered_json;
  const auto us = [](const LinkTiming::Delay& delay) {
    return Ordered{
        {"median"_key, 1e6 * delay.median}, {"p99"_key, 1e6 * delay.p99}, {"max"_key, 1e6 * delay.most}};
  };
  Ordered json = Ordered::parse(summary);
  json["real_time"_key] = {{"periods"_key, timing.periods},
                           {"missed"_key, timing.missed},
                           {"wake_us"_key, us(timing.wake)},
                           {"arrival_us"_key, us(timing.arrival)},
                           {"cpu"_key, timing.cpu}};
  return json_text(json, 2) + "\n";
}

/// Flies the scenario with its controllers, as fly_logged() of the library; shows it on a page if
/// requested.
LoggedFlight fly_shown(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                       const ShowOptions& view, const Controllers& controllers,
                       TeamSwitcher* team_switcher = nullptr, const McapWords& flown = {},
                       LinkedFlight* linked = nullptr) {
  std::optional<LinkedSink> shown;
  std::unique_ptr<Sink<Sample>> watched;
  Progress progress(scenario.simulation.duration);
  FlightOptions options{.team_switcher = team_switcher,
                        .allocations = allocations,
                        .written = [&](double time) { progress.show(time); },
                        .flown = flown};
  options.watched = [&](Sink<Sample>& log, const Sample& prototype) -> Sink<Sample>& {
    if (linked != nullptr) shown.emplace(log, linked->world, linked->stop);
    Sink<Sample>& kept = shown ? static_cast<Sink<Sample>&>(*shown) : log;
    if constexpr (has("server"))
      if (view.show) return *(watched = show_on_page(kept, scenario, prototype, view.serve));
    return kept;
  };
  if (linked != nullptr) {
    options.world = &linked->world;
    options.stop = &linked->stop;
    options.fly = [linked](ClosedLoop& loop, Sink<Sample>& sink) { return fly_linked(*linked, loop, sink); };
    options.summarised = [linked](const std::string& summary) {
      return with_timing(summary, linked->world.timing());
    };
  }
  LoggedFlight flight = fly_logged(scenario, folder, clock, controllers, options);
  progress.end();
  if (shown && shown->too_old())
    flight.faults.emplace_back("what was known of a robot grew too old: all landed");
  return flight;
}

LoggedFlight fly_shown(const Scenario& scenario, const std::filesystem::path& folder, Clock& clock,
                       const ShowOptions& view, LinkedFlight* linked) {
  if (PartExchange* const exchange = linked != nullptr ? linked->world.exchange() : nullptr) {
    PartSolver solver(scenario.team, solver_maker(scenario.solver, scenario.horizon), *exchange);
    return fly_shown(scenario, folder, clock, view, {solver}, nullptr, {}, linked);
  }
  const auto begin = std::chrono::steady_clock::now();
  const Controls controls(scenario);
  constexpr std::size_t large = 64;  // smaller teams are set up without a noticeable delay
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (scenario.team.agents().size() >= large)
    print_sentence(fmt::format("{} robots are set up in {:.2g} s", scenario.team.agents().size(), took));
  if (const std::string reported = controls.kernels().sentence(); !reported.empty()) print_sentence(reported);
  return fly_shown(scenario, folder, clock, view, controls.controllers(), controls.team_switcher(), {},
                   linked);
}

/// The same scenario with one solver for the whole team; its log records this.
Scenario as_one(const Scenario& scenario) {
  if (!scenario.partition) return scenario;
  Scenario one = parse_scenario(
      scenario.text, scenario.file, *scenario.registry,
      {.files = scenario.files, .set = {fmt::format("partition.part=\"{}\"", PartitionPlan::all)}});
  one.solver = scenario.solver;
  one.pool = scenario.pool;
  one.simulation.seed = scenario.simulation.seed;
  return one;
}

int run(const RunOptions& options, const Registry& parts) {
  Scenario scenario;
  std::optional<PartitionChoice> partition;
  std::optional<RunFolder> folder;
  try {
    scenario = read(options, parts);
    if (options.partition)
      partition =
          read_partition(scenario, *options.partition, options.order, options.exchanges, options.threads);
    else
      partition = partition_of(scenario, options.threads);
    if (options.view.tune && (!options.realtime || partition))
      throw std::invalid_argument(
          "--tune, expected beside --realtime and of one solver for all; `sightline view --tune` can wait, "
          "too");
    if (options.view.tune) make_tunable(scenario);
    scenario.pool = std::make_shared<ThreadPool>(options.threads);
    if (!partition) share_updates(scenario.solver, scenario.pool);  // else subteams are solved in parallel
    folder.emplace(options.output.empty() ? std::filesystem::path("out") / scenario.name : options.output,
                   scenario, partition.has_value());
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
  for (const std::string& sentence : keys_without_effect(scenario)) print_sentence("warning: " + sentence);
  outlive_the_terminal();
  SimulatedClock simulated;
  SteadyClock steady;
  try {
    return fly(std::move(scenario), *folder, options.realtime ? static_cast<Clock&>(steady) : simulated,
               options.view, partition ? &*partition : nullptr);
  } catch (const std::invalid_argument& error) {  // of objects built before the flight
    print_message("{}: {}\n", options.scenario.file.native(), error.what());
    return 2;
  }
}

int report(const std::filesystem::path& folder) {
  std::optional<FolderLock> lock;
  try {
    (void)log_of(folder);
    lock.emplace(folder, std::initializer_list<std::string_view>{"run.mcap", "timing.csv", "summary.json",
                                                                 "report.html"});
  } catch (const std::invalid_argument& error) {
    print_message("{}\n", error.what());
    return 2;
  }
  try {
    write_report(folder);
  } catch (const std::exception& error) {
    print_sentence(sentence_of(error));
    return 1;
  }
  print("{}\n", (folder / "report.html").native());
  return 0;
}

}  // namespace

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
  McapWords words;
  if (partition != nullptr && !partition->messages)
    words = {{"partition", partition->text},
             {"order", std::string(to_string(partition->order))},
             {"exchanges", fmt::format("{}", partition->exchanges)}};
  const LoggedFlight flight = parts ? fly_shown(scenario, folder, clock, view, {*parts}, nullptr, words)
                                    : fly_shown(scenario, folder, clock, view, linked);
  for (const std::string& fault : flight.faults) print_sentence(fault);
  bool bad = !flight.faults.empty();

  std::vector<std::string> summaries = {flight.summary};
  std::string of_parts;
  if (parts && flight.logged) {
    SimulatedClock simulated;
    scenario.solver = of_whole;
    const LoggedFlight whole = fly_shown(as_one(scenario), folder / "whole", simulated, {}, nullptr);
    for (const std::string& fault : whole.faults)
      print_sentence(fmt::format("the whole team by one solver: {}", fault));
    bad = bad || !whole.logged;
    summaries.push_back(whole.summary);
    of_parts = parts->print_message(folder, flight.summary, whole.summary);
  }
  for (const std::string& name : scenario.simulation.compare) {
    if (!flight.logged) break;
    SimulatedClock simulated;
    scenario.solver = solver_named(name, registry_of(scenario));
    scenario.tuned = nullptr;
    const LoggedFlight other = fly_shown(as_one(scenario), folder / name, simulated, {}, nullptr);
    for (const std::string& fault : other.faults)
      print_sentence(fmt::format("compared with {}: {}", name, fault));
    bad = bad || !other.logged;
    summaries.push_back(other.summary);
  }

  if (flight.logged) {
    try {
      write_report(folder);
    } catch (const std::exception& error) {
      print_sentence(sentence_of(error));
      bad = true;
    }
  }
  if (flight.outcome.updates == 0) return bad ? 1 : 0;  // it did not take off
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
  // On a full disk, files are missing.
  for (const char* file : {"report.html", "run.mcap", "summary.json"})
    if (std::error_code error; flight.begun && std::filesystem::exists(folder / file, error))
      print("{}\n", (folder / file).native());
  return bad ? 1 : 0;
}

Execute describe_run(CLI::App& app) {
  const auto command = std::make_shared<RunOptions>();
  app.description("Fly a scenario; write log, summary and report");
  add_scenario(app, command->scenario);
  app.add_option("-o,--output", command->output, "Folder for the results [out/NAME]");
  app.add_option("--solver", command->solver, "Solver, instead of the scenario's");
  app.add_option("--seed", command->seed, "Seed of all random numbers, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  app.add_flag("--realtime", command->realtime, "Run in real time; missed periods are events");
  add_threads(app, command->threads);
  add_show(app, command->view);

  CLI::Option* partition =
      app.add_option("--partition", command->partition, "Subteams, each with its own solver: \"a,b | c,d\"");
  app.add_option("--order", command->order, "Order of the subteams: jacobi or gauss_seidel [gauss_seidel]")
      ->needs(partition);
  app.add_option("--exchanges", command->exchanges, "Exchanges of predictions per update [1]")
      ->needs(partition);
  return [command](const Registry& registry, char**) { return run(*command, registry); };
}

Execute describe_report(CLI::App& app) {
  const auto folder = std::make_shared<std::filesystem::path>();
  app.description("Make report.html again from a run's files");
  app.add_option("DIR", *folder, "Folder of a run")->required();
  return [folder](const Registry&, char**) { return report(*folder); };
}

}  // namespace sightline::cli
