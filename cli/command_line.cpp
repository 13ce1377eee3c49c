#include "sightline/command_line.hpp"

#include <CLI/CLI.hpp>
#include <exception>
#include <sstream>

#include "cli/commands.hpp"
#include "cli/output.hpp"

namespace sightline {
namespace {

constexpr int runs_max = 1'000'000'000;
constexpr std::uint64_t seed_max = 9'223'372'036'854'775'807;  // as in a scenario

int execute(int argc, char** argv, const Parts& parts) {
  using namespace cli;

  CLI::App app(
      "sightline keeps robot teams in each other's sight: real-time nonlinear MPC of coupled robots.");
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "Help of all commands");

  RunOptions run_options;
  CLI::App* run_command = app.add_subcommand("run", "Fly a scenario; write log, summary and report");
  run_command->add_option("SCENARIO", run_options.scenario, "Scenario file (TOML)")->required();
  run_command->add_option("-o,--output", run_options.output, "Folder for the results [out/NAME]");
  run_command->add_option("--solver", run_options.solver, "Solver, instead of the scenario's");
  run_command->add_option("--seed", run_options.seed, "Seed of all chance, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  run_command->add_flag("--realtime", run_options.realtime,
                        "Pace by the wall clock; missed periods are events");

  CLI::Option* partition = run_command->add_option("--partition", run_options.partition,
                                                   "Parts that plan by themselves: \"a,b | c,d\"");
  run_command->add_option("--order", run_options.order, "Of the parts: jacobi or gauss_seidel [gauss_seidel]")
      ->needs(partition);
  run_command->add_option("--exchanges", run_options.exchanges, "Rounds of the parts in an update [1]")
      ->needs(partition);

  std::filesystem::path scenario, folder;
  CLI::App* check_command = app.add_subcommand("check", "Read a scenario and say what it describes");
  check_command->add_option("SCENARIO", scenario, "Scenario file (TOML)")->required();
  bool expanded = false;
  check_command->add_flag("--print", expanded, "Print the scenario with its templates and ranges expanded");

  CLI::App* report_command = app.add_subcommand("report", "Make report.html again from a run's files");
  report_command->add_option("DIR", folder, "Folder of a run")->required();

  PotentialOptions potential_options;
  CLI::App* potential_command =
      app.add_subcommand("potential", "Draw and judge the potentials of a scenario's couplings");
  potential_command->add_option("SCENARIO", potential_options.scenario, "Scenario file (TOML)")->required();
  potential_command->add_option("--couple", potential_options.couple,
                                "One coupling, from 0 in the file's order");
  potential_command->add_option("-o,--output", potential_options.output,
                                "Folder for the results [out/NAME/potential]");

  CLI::App* explain_command =
      app.add_subcommand("explain", "Say before a flight which limits can hold and what they are worth");
  explain_command->add_option("SCENARIO", scenario, "Scenario file (TOML)")->required();

  CampaignCommand campaign_options;
  CLI::App* campaign_command =
      app.add_subcommand("campaign", "Fly a scenario many times, as its [campaign] draws");
  campaign_command->add_option("SCENARIO", campaign_options.scenario, "Scenario file (TOML)")->required();
  campaign_command->add_option("--runs", campaign_options.runs, "Closed loops")
      ->capture_default_str()
      ->check(CLI::Range(1, runs_max));
  campaign_command
      ->add_option("--seed", campaign_options.seed, "Seed of all draws, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  campaign_command->add_option("--threads", campaign_options.threads, "Runs in the air at once [all cores]")
      ->check(CLI::Range(1, 1024));
  campaign_command->add_option("-o,--output", campaign_options.output,
                               "Folder for the results [out/NAME/campaign]");
  campaign_command->add_option("--only", campaign_options.only, "Fly this run alone, with log and report")
      ->check(CLI::Range(0, runs_max - 1));
  campaign_command->add_option("--beside", campaign_options.beside,
                               "Another scenario of the same robots that flies the same draws");

  CLI::App* parts_command = app.add_subcommand(
      "parts", "List the robots, potentials, references and limits that a scenario may use");
  bool parts_as_json = false;
  parts_command->add_flag("--json", parts_as_json, "JSON instead of tables");

  CLI::App* version_command = app.add_subcommand("version", "Version and compiler");

  BenchCommand bench_options;
  CLI::App* bench_command = app.add_subcommand("bench", "Time the solvers and compare them with the optimum");
  bench_command->add_option("--case", bench_options.name, "One case, instead of all");
  bench_command->add_option("--solver", bench_options.solver, "Solver [newton_riccati]");
  bench_command->add_flag("--json", bench_options.json, "JSON instead of a table");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::ostringstream out, err;
    const int code = app.exit(e, out, err);
    write_result(out.str());
    write_message(err.str());
    return code == 0 ? 0 : 2;
  }
  if (run_command->parsed()) return run(run_options, parts);
  if (check_command->parsed()) return check(scenario, expanded, parts);
  if (report_command->parsed()) return report(folder);
  if (potential_command->parsed()) return potential(potential_options, parts);
  if (explain_command->parsed()) return explain(scenario, parts);
  if (campaign_command->parsed()) return campaign(campaign_options, parts);
  if (parts_command->parsed()) return list_parts(parts_as_json, parts);
  if (version_command->parsed()) return version();
  if (bench_command->parsed()) return bench(bench_options);
  return 2;
}

}  // namespace

int command_line(int argc, char** argv, const Parts& parts) {
  using namespace cli;
  open_streams();
  int code = 1;
  try {
    code = execute(argc, argv, parts);
  } catch (const std::exception& e) {
    tell("sightline: {}\n", e.what());
  }
  return finish(code);
}

}  // namespace sightline
