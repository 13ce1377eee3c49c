/// Prints docs/reference.md: registered parts, keys, topics and commands, from the code that reads or writes them.
/// scripts/reference.sh writes the file.
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/fleet/link_fault.hpp"
#include "cli/arguments.hpp"
#include "sightline/analysis/localization/rig_filter.hpp"
#include "sightline/estimate/team_filter.hpp"
#include "sightline/estimator.hpp"
#include "sightline/judge/summary_keys.hpp"
#include "sightline/record/log_table.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/csv_lists.hpp"
#include "sightline/sensors.hpp"
#include "sightline/solvers.hpp"
#include "sightline/supervisor.hpp"
#include "sightline/vehicle.hpp"
#include "sightline/world.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

/// The described keys of a struct that a table of the scenario fills.
template <class Part>
PartText keys(std::string_view table, const Part& part) {
  PartText text{std::string(table), parameter_texts(part)};
  for (ParameterText& p : text.parameters)
    if (!p.must_be_given) p.fallback = p.value;
  return text;
}

std::string section(std::string_view title, const std::vector<PartText>& tables) {
  return fmt::format("### {}\n\n{}\n", title, parameters_table("table", tables));
}

/// The keys of each kind in a list.
template <class... Kind>
std::string kinds(std::string_view title, std::string_view table, const std::variant<Kind...>&) {
  return section(title, {keys(fmt::format("{} {}", table, Kind::name), Kind{})...});
}

std::string topics_table() {
  std::string text = "| topic | schema | fields | meaning |\n|---|---|---|---|\n";
  for (const LogTopic& one : log_topics)
    text += fmt::format("| `{}` | `{}` | {} | {} |\n", one.topic, one.schema, one.fields, one.meaning);
  return text;
}

std::string commands() {
  const cli::Arguments arguments;
  std::string text;
  for (const CLI::App* command : arguments.app.get_subcommands({}))
    text += fmt::format("### sightline {}\n\n```text\n{}```\n\n", command->get_name(), command->help());
  return text;
}

std::string reference() {
  const Registry& registry = built_in_registry();
  return "# Reference\n\n"
         "Made by `scripts/reference.sh` from the code that reads the keys; do not edit. `sightline parts` "
         "prints the tables of\n"
         "registered parts too, those of a program's own included.\n\n"
         "## Registered parts\n\n### Robots\n\n" +
         parameters_table(registry.robots) + "\n### Potentials\n\n" + parameters_table(registry.potentials) +
         "\n### References\n\n" + parameters_table(registry.references) + "\n### Limits\n\n" +
         parameters_table(registry.limits) + "\n## Keys\n\n" +
         section("Horizon", {keys("[horizon]", Horizon{})}) +
         section("Solvers", {keys("[solver] newton_riccati", NewtonRiccatiOptions{}),
                             keys("[solver] cmscgmres, cgmres", ContinuationOptions{})}) +
         section("Compensation", {keys("[agent.NAME]", RobotCompensation{})}) +
         section("Sensors", {keys("[agent.NAME.sensor], [agent.NAME.sensors.SENSOR]", SensorMount{}),
                             keys("[agent.NAME.camera], [agent.NAME.sensors.SENSOR.camera]", Camera{}),
                             keys("[agent.NAME.tags]", Tags{}), keys("[obstacle.NAME.hull]", Hull{})}) +
         section("Vehicles", {keys("[agent.NAME.vehicle]", Vehicle{}),
                              keys("[agent.NAME.vehicle] imu", Imu{}), keys("[world]", DownwashOptions{})}) +
         section("Targets and obstacles", {keys("[target.NAME], [obstacle.NAME]", UncooperativeBody{})}) +
         kinds("Motions", "motion", Motion{}) +
         section("Paths from files", {keys("waypoints, steps, motion waypoints", ListFile{})}) +
         section("Simulation",
                 {keys("[simulation]", Simulation{}), keys("[simulation.disturbance]", Disturbances{}),
                  keys("[simulation.disturbance] airflow", Airflow{}),
                  keys("[simulation.disturbance] noise", Noise{}),
                  keys("[simulation.disturbance] odometry", Odometry{})}) +
         section(
             "Safety",
             {keys("[safety]", Safety{}), keys("[safety]", Safety{}.barrier_options),
              keys("[[safety.zone]]", Zone{}), keys("[safety.supervisor]", LadderTimes{}),
              keys("[safety.supervisor]", LadderSigmas{}), keys("[safety.supervisor]", SupervisorOptions{}),
              keys("[safety.supervisor]", TrackLimits{}), keys("[safety.search]", SearchOptions{}),
              keys("[[certify_view]]", CertifiedView{}), keys("[[certify_view]]", ViewBounds{})}) +
         section("Estimates", {keys("[estimate], [agent.NAME.estimate]", FilterOptions{}),
                               keys("[estimate.broadcast] simulated", Radio{}),
                               keys("[estimate.broadcast] received", BroadcastOptions{}),
                               keys("[localize] of recorded teams", TeamNoise{}),
                               keys("[localize] of camera rigs", RigNoise{})}) +
         section("Loop and log", {keys("[loop]", LoopKeys{}), keys("[log]", LogOptions{})}) +
         section("Campaign",
                 {keys("[campaign]", CampaignPlan{}), keys("[campaign.evasion]", EvasionPlan{})}) +
         kinds("Links", "[agent.NAME.link]", LinkKind{}) +
         section("Partition", {keys("[partition.exchange]", ExchangeOptions{})}) +
         "### Faults of links\n\n`[[fleet.fault]]`\n\n" + link_fault_table() +
         "\n## Keys of summary.json\n\n" + std::string(summary_keys) +
         "\n## Topics of run.mcap\n\nA message in JSON also has its `time` [s].\n\n" + topics_table() +
         "\n## Commands\n\n" + commands();
}

}  // namespace
}  // namespace sightline

int main() {
  std::string text = sightline::reference();
  text.pop_back();  // one newline at the end of the file
  return std::fputs(text.c_str(), stdout) < 0 ? 1 : 0;
}
