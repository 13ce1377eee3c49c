#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>
#include <csignal>

#include "bridges/dds/fleet/bridge.hpp"
#include "bridges/dds/fleet/link.hpp"
#include "cli/arguments.hpp"
#include "cli/fault_keys.hpp"
#include "cli/fleet.hpp"
#include "cli/output.hpp"
#include "sightline/base.hpp"
#include "sightline/base/c_callback.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/registry.hpp"
#include "sightline/run/realtime.hpp"
#include "sightline/scenario.hpp"
#include "sightline/solvers.hpp"

namespace sightline::cli {
namespace {

struct FlyCommand {
  NamedScenario fleet;
  std::filesystem::path output;
  bool dry_run = false, wait = false;
  ShowOptions view;
  int threads = 1;
  std::string part, partition;  ///< empty: by the scenario
};

struct VehiclesCommand {
  NamedScenario fleet;
  double seconds = 1e9;
};

// Global, as signals belong to the process.
Interrupts interrupt_count{0};
std::atomic<bool> interrupted{false};

/// The --set assignment of another partition, with the scenario's message exchange.
std::string partition_assignment(const FlyCommand& command, const Registry& parts) {
  const Scenario scenario = read_fleet(command.fleet, parts);
  const ExchangeOptions exchange = scenario.partition ? scenario.partition->exchange : ExchangeOptions{};
  std::string words = "partition={";
  int number = 0;
  for (const PartSpec& part : parse_parts(command.partition)) {
    ++number;
    words += fmt::format("{}=[", part.name.empty() ? fmt::format("p{}", number) : part.name);
    for (const std::string& robot : part.robots) words += fmt::format("\"{}\",", robot);
    words += "],";
  }
  return words + fmt::format(
                     "exchange={{stale_after={},speed_max={},delay={},jitter={},loss={},offset={},flown_by="
                     "\"{}\"}}}}",
                     exchange.stale_after, exchange.speed_max, exchange.delay, exchange.jitter, exchange.loss,
                     exchange.offset, exchange.flown_by == MessagesBy::network ? "network" : "simulation");
}

/// Rejects a fleet with a partition if no part to plan is given.
void refuse_without_part(const Scenario& scenario, const FlyCommand& command) {
  if (!scenario.partition || !scenario.partition->part.empty()) return;
  std::vector<std::string_view> names;
  for (const PlannedPart& part : scenario.partition->parts) names.push_back(part.name);
  throw std::invalid_argument(
      fmt::format("{}: --part is missing, expected one of {}, or {} where one solver plans all",
                  command.fleet.file.native(), fmt::join(names, ", "), PartitionPlan::all));
}

void on_interrupt(int) {
  ++interrupt_count;
  interrupted = true;
}

}  // namespace

Interrupts& interrupts() { return interrupt_count; }
std::atomic<bool>& stop_flight() { return interrupted; }

void listen_to_interrupts() {
  struct sigaction action {};
  action.sa_handler = c_callback<on_interrupt>;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
}

Scenario read_fleet(const NamedScenario& fleet, const Registry& parts) {
  Scenario scenario = fleet.read(parts);
  if (!scenario.links)
    throw std::invalid_argument(fmt::format(
        "{}:1: fleet is missing, expected a [fleet] with the links of the robots", fleet.file.native()));
  refuse_without_bridge(parts);
  return scenario;
}

void refuse_without_bridge(const Registry& parts) {
  if (parts.bridge == nullptr)
    throw std::invalid_argument(
        "this sightline has no bridge to robots, expected one that was built with Cyclone DDS");
}

bool say_end(const LinkedWorld& world) {
  for (const std::string& line : world.counts()) print_sentence(line);
  const std::vector<std::string> faults = world.faults();
  for (const std::string& fault : faults) print_sentence(fault);
  return !faults.empty();
}

namespace {

/// Executes all steps before a flight except arming. It writes nothing, so a folder keeps its
/// flight.
int fly_dry(const Scenario& scenario, LinkedWorld& world) {
  if (world.exchange() == nullptr) (void)Controls(scenario);  // throws what a flight would
  run_apart([&] {
    offer_sentence(become_realtime(control_priority).sentence());
    (void)world.take_off(Arming::dry_run, interrupts(), offer_sentence);
  });
  return say_end(world) ? 1 : 0;
}

int fly_fleet(const FlyCommand& command, const Registry& parts) {
  std::unique_ptr<LinkedWorld> world;
  std::optional<RunFolder> folder;
  Scenario scenario;
  try {
    NamedScenario fleet = command.fleet;
    if (!command.partition.empty()) fleet.set.push_back(partition_assignment(command, parts));
    if (!command.part.empty() && command.partition.empty() && !read_fleet(fleet, parts).partition)
      throw std::invalid_argument(
          fmt::format("{}: --part = {}, expected a fleet with [partition], or --partition",
                      fleet.file.native(), command.part));
    if (!command.part.empty()) fleet.set.push_back(fmt::format("partition.part=\"{}\"", command.part));
    scenario = read_fleet(fleet, parts);
    if (changes_surroundings(scenario.script))
      throw std::invalid_argument(
          fmt::format("{}: an event with move, wind or fault, expected none: it changes a simulated world",
                      fleet.file.native()));
    refuse_without_part(scenario, command);
    if (command.view.tune) make_tunable(scenario, TunedScript::Scope::team);
    scenario.simulation.compare.clear();
    lift_deadline(scenario.solver);  // replayable: no wall-clock deadline affects the plan
    scenario.pool = std::make_shared<ThreadPool>(command.threads);
    share_updates(scenario.solver, scenario.pool);
    check_solvers(scenario);
    std::filesystem::path output = std::filesystem::path("out") / scenario.name;
    if (scenario.partition) output /= scenario.partition->part;
    if (!command.dry_run) folder.emplace(command.output.empty() ? output : command.output, scenario);
    world = parts.bridge->connect(scenario);
    const auto& localized = scenario.localization.robots;
    if (!localized.empty() && world->measured_max().motions == 0)
      throw std::invalid_argument(
          fmt::format("{}: agent.{}.localization = vision, expected \"global\": its link has no motion",
                      command.fleet.file.native(), scenario.team.name(localized.front().robot)));
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
  outlive_the_terminal();
  listen_to_interrupts();
  SteadyClock clock;
  LinkedFlight linked{*world, command.wait ? Arming::on_call : Arming::real, interrupts(), stop_flight()};
  int code = 2;
  try {
    if (!folder) return fly_dry(scenario, *world);
    code = fly(std::move(scenario), *folder, clock, command.view, nullptr, &linked);
  } catch (const std::invalid_argument& error) {  // of objects built before the flight
    print_message("{}: {}\n", command.fleet.file.native(), error.what());
    return 2;
  }
  return say_end(*world) && code == 0 ? 1 : code;
}

int vehicles(const VehiclesCommand& command, const Registry& parts) {
  const Scenario scenario = read_fleet(command.fleet, parts);
  const std::unique_ptr<VehicleSimulators> vehicle_simulators = parts.bridge->vehicle_simulator(scenario);
  listen_to_interrupts();
  print_sentence(fmt::format("{} simulated vehicles, until Ctrl-C", fleet_of(scenario).links.size()));
  {
    const auto help = [] { print_message("{}", fault_keys_help()); };
    const FaultKeys keys(
        [&](FaultTyping::Requested requested) {
          print_sentence(vehicle_simulators->toggle(requested.robot, requested.kind));
        },
        help);
    if (FaultKeys::on_a_terminal()) help();
    vehicle_simulators->run(command.seconds, interrupts(),
                            [](std::string_view sentence) { print_sentence(sentence); });
  }
  for (const std::string& line : vehicle_simulators->counts()) print("{}\n", line);
  return 0;
}

}  // namespace

Execute describe_fly(CLI::App& app) {
  const auto command = std::make_shared<FlyCommand>();
  app.description("Fly a fleet of real robots; write log, summary and report");
  add_fleet(app, command->fleet);
  app.add_option("-o,--output", command->output, "Folder for the results [out/NAME]");
  const auto dry_run = app.add_flag("--dry-run", command->dry_run, "All but arm; writes nothing");
  app.add_flag("--wait", command->wait, "Take off when the service ~/start is called")->excludes(dry_run);
  app.add_option("--part", command->part,
                 "The part of [partition] that is planned here; all: one solver plans all");
  app.add_option("--partition", command->partition,
                 "Parts in place of those of [partition]: \"front: a,b | back: c,d\"");
  add_threads(app, command->threads);
  if (CLI::Option* const show = add_show(app, command->view)) show->excludes(dry_run);
  return [command](const Registry& registry, char**) { return fly_fleet(*command, registry); };
}

Execute describe_vehicles(CLI::App& app) {
  const auto command = std::make_shared<VehiclesCommand>();
  app.description("Simulate the robots of a fleet on their topics");
  add_fleet(app, command->fleet);
  app.add_option("--seconds", command->seconds, "How long [s]; until Ctrl-C")->check(CLI::Range(0.0, 1e9));
  return [command](const Registry& registry, char**) {
    return refusing([&] { return vehicles(*command, registry); });
  };
}

}  // namespace sightline::cli
