#include "cli/arguments.hpp"

#include <array>

#include "cli/components.hpp"
#include "sightline/base.hpp"

namespace sightline::cli {
namespace {

struct Command {
  std::string_view name;
  Describe* describe;            // null: its component is left out
  std::string_view component{};  // of the library; empty: every build has it
};

constexpr Command of(std::string_view component, std::string_view name, Describe* describe) {
  return {name, has(component) ? describe : nullptr, component};
}

/// All commands, in the order of the help.
constexpr std::array all_commands = {
    Command{"run", describe_run},
    Command{"fly", describe_fly},
    Command{"vehicles", describe_vehicles},
    Command{"doctor", describe_doctor},
    Command{"check", describe_check},
    Command{"report", describe_report},
    of("server", "view", describe_view),
    Command{"replay", describe_replay},
    of("analysis", "identify", describe_identify),
    of("analysis", "localize", describe_localize),
    of("analysis", "potential", describe_potential),
    of("analysis", "explain", describe_explain),
    of("campaign", "campaign", describe_campaign),
    of("campaign", "tune", describe_tune),
    of("import", "import", describe_import),
    Command{"parts", describe_parts},
    Command{"version", describe_version},
    Command{"bench", describe_bench},
};

}  // namespace

void add_set(CLI::App& command, std::vector<std::string>& set) {
  command
      .add_option("--set", set,
                  "KEY=VALUE of the scenario, couple[0].weight=0.5 or world.kind=rotors; may be repeated")
      ->allow_extra_args(false);
}

void add_scenario(CLI::App& command, NamedScenario& scenario, const char* name, const char* what) {
  command.add_option(name, scenario.file, what)->required();
  add_set(command, scenario.set);
}

void add_fleet(CLI::App& command, NamedScenario& fleet) {
  add_scenario(command, fleet, "FLEET", "Scenario file with [fleet] (TOML)");
}

void add_serve(CLI::App& command, ServeOptions& serve, CLI::Option* needed) {
  CLI::Option* port = command.add_option("--port", serve.port, "Port of the page; 0: a free one [8765]")
                          ->check(CLI::Range(0, 65535));
  CLI::Option* address = command.add_option(
      "--bind", serve.address, "IPv4 address to be reached at from other machines, by a token [127.0.0.1]");
  CLI::Option* origins =
      command
          .add_option("--allow-origin", serve.origins,
                      "Another page that may subscribe to topics, https://app.foxglove.dev; may be repeated")
          ->allow_extra_args(false);
  if (needed == nullptr) return;
  for (CLI::Option* option : {port, address, origins}) option->needs(needed);
}

CLI::Option* add_show(CLI::App& command, ShowOptions& view) {
  if (!has("server")) return nullptr;
  CLI::Option* const show = command.add_flag("--view", view.show, "Show the flight in the browser");
  add_serve(command, view.serve, show);
  command.add_flag("--tune", view.tune, "Let those who look on change it")->needs(show);
  return show;
}

void add_threads(CLI::App& command, int& threads) {
  command
      .add_option(
          "--threads", threads,
          "Threads that share the updates, barriers and simulation of a large team, or many parts [1]")
      ->check(CLI::Range(1, ThreadPool::most));
}

std::string_view missing_component(std::string_view command) {
  for (const Command& one : all_commands)
    if (one.name == command && one.describe == nullptr) return one.component;
  return {};
}

std::string left_out(std::string_view what, std::string_view component) {
  return fmt::format(
      "{} is left out of this build, expected one with the component {}: -D SIGHTLINE_COMPONENTS=\"campaign;"
      "analysis;server;import\" has all",
      what, component);
}

Arguments::Arguments()
    : app("sightline keeps robot teams in each other's sight: real-time nonlinear MPC of coupled robots.",
          "sightline") {
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "Help of all commands");
  app.set_version_flag("--version", version_text, "Version and compiler");
  for (const Command& one : all_commands) {
    if (one.describe == nullptr) continue;
    CLI::App& command = *app.add_subcommand(std::string(one.name));
    commands.emplace_back(&command, one.describe(command));
  }
}

}  // namespace sightline::cli
