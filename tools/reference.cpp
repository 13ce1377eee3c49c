/// Prints docs/reference.md: keys, registered parts and commands, from the code that reads them.
/// scripts/reference.sh writes the file.
#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/fleet/link_fault.hpp"
#include "cli/arguments.hpp"
#include "sightline/estimator.hpp"
#include "sightline/registry.hpp"
#include "sightline/sensors.hpp"
#include "sightline/solvers.hpp"
#include "sightline/supervisor.hpp"
#include "sightline/vehicle.hpp"
#include "sightline/world.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

/// The keys of a described struct, under the scenario table that holds them.
template <class Part>
std::string keys(std::string_view title, std::string_view table, const Part& part) {
  std::string text =
      fmt::format("### {}\n\n`{}`\n\n| key | default | range | meaning |\n|---|---|---|---|\n", title, table);
  for (const ParameterText& p : parameter_texts(part)) {
    const std::string value =
        p.unit.empty() || p.fallback.empty() ? p.fallback : fmt::format("{} {}", p.fallback, p.unit);
    text += fmt::format("| `{}` | {} | {} | {} |\n", p.key,
                        p.must_be_given ? "must be given"
                        : value.empty() ? "none"
                                        : value,
                        p.range, p.meaning);
  }
  return text + '\n';
}

/// The keys of each kind of link.
template <class... Kind>
std::string links(const std::variant<Kind...>&) {
  return (keys(fmt::format("Links of {}", Kind::name),
               fmt::format("[agent.NAME.link] kind = \"{}\"", Kind::name), Kind{}) +
          ...);
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
         keys("Vehicle", "[agent.NAME.vehicle] parameters", Vehicle{}) +
         keys("Inertial measurement unit", "[agent.NAME.vehicle] imu", Imu{}) +
         keys("Downwash", "[world]", DownwashOptions{}) +
         keys("Odometry", "[simulation.disturbance] odometry", Odometry{}) +
         keys("Filters", "[estimate], [agent.NAME.estimate]", FilterOptions{}) +
         keys("Broadcasts as simulated", "[estimate.broadcast]", Radio{}) +
         keys("Broadcasts as received", "[estimate.broadcast]", BroadcastOptions{}) +
         keys("Search", "[safety.search]", SearchOptions{}) +
         keys("Camera", "[agent.NAME.camera]", Camera{}) + keys("Tags", "[agent.NAME.tags]", Tags{}) +
         keys("Hull", "[obstacle.NAME.hull]", Hull{}) + links(LinkKind{}) +
         keys("Exchange of parts", "[partition.exchange]", ExchangeOptions{}) +
         "### Faults of links\n\n`[[fleet.fault]]`\n\n" + link_fault_table() + "\n## Commands\n\n" +
         commands();
}

}  // namespace
}  // namespace sightline

int main() {
  std::string text = sightline::reference();
  text.pop_back();  // one newline at the end of the file
  return std::fputs(text.c_str(), stdout) < 0 ? 1 : 0;
}
