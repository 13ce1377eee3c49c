/// Description of the command line. Each command describes its options in its own file; the manual
/// pages and the shell completion are generated from them.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/commands.hpp"

namespace sightline::cli {

/// Executes a parsed command and returns the exit code.
using Execute = std::function<int(const Registry& registry, char** argv)>;
/// Describes a command, with its options.
using Describe = Execute(CLI::App& app);

Describe describe_run, describe_fly, describe_vehicles, describe_doctor, describe_check, describe_report,
    describe_view, describe_replay, describe_identify, describe_localize, describe_potential,
    describe_explain, describe_campaign, describe_tune, describe_import, describe_parts, describe_version,
    describe_bench;

struct Arguments {
  Arguments();

  CLI::App app;
  std::vector<std::pair<const CLI::App*, Execute>> commands;
};

/// The component of a command that this build leaves out; empty: the command is built or unknown.
std::string_view missing_component(std::string_view command);

inline constexpr std::uint64_t seed_max = 9'223'372'036'854'775'807;  // as in a scenario

void add_set(CLI::App& command, std::vector<std::string>& set);
void add_scenario(CLI::App& command, NamedScenario& scenario, const char* name = "SCENARIO",
                  const char* what = "Scenario file (TOML)");
void add_fleet(CLI::App& command, NamedScenario& fleet);
void add_serve(CLI::App& command, ServeOptions& serve, CLI::Option* needed = nullptr);
/// @return the option --view; null: this build has no server
CLI::Option* add_show(CLI::App& command, ShowOptions& view);
void add_threads(CLI::App& command, int& threads);

}  // namespace sightline::cli
