#include "cli/arguments.hpp"

#include "sightline/base.hpp"

namespace sightline::cli {
namespace {

constexpr int runs_max = 1'000'000'000;
constexpr std::uint64_t seed_max = 9'223'372'036'854'775'807;  // as in a scenario

void add_set(CLI::App& command, std::vector<std::string>& set) {
  command
      .add_option("--set", set,
                  "KEY=VALUE of the scenario, couple[0].weight=0.5 or world.kind=rotors; may be repeated")
      ->allow_extra_args(false);
}

void add_scenario(CLI::App& command, NamedScenario& scenario, const char* name = "SCENARIO",
                  const char* what = "Scenario file (TOML)") {
  command.add_option(name, scenario.file, what)->required();
  add_set(command, scenario.set);
}

void add_fleet(CLI::App& command, NamedScenario& fleet) {
  add_scenario(command, fleet, "FLEET", "Scenario file with [fleet] (TOML)");
}

void add_serve(CLI::App& command, ServeOptions& serve, CLI::Option* needed = nullptr) {
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

}  // namespace

Arguments::Arguments()
    : app("sightline keeps robot teams in each other's sight: real-time nonlinear MPC of coupled robots.",
          "sightline") {
  app.require_subcommand(1);
  app.set_help_all_flag("--help-all", "Help of all commands");
  app.set_version_flag("--version", version_text, "Version and compiler");

  run_command = app.add_subcommand("run", "Fly a scenario; write log, summary and report");
  add_scenario(*run_command, run.scenario);
  run_command->add_option("-o,--output", run.output, "Folder for the results [out/NAME]");
  run_command->add_option("--solver", run.solver, "Solver, instead of the scenario's");
  run_command->add_option("--seed", run.seed, "Seed of all random numbers, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  run_command->add_flag("--realtime", run.realtime, "Run in real time; missed periods are events");
  add_threads(*run_command, run.threads);
  add_show(*run_command, run.view);

  CLI::Option* partition = run_command->add_option("--partition", run.partition,
                                                   "Subteams, each with its own solver: \"a,b | c,d\"");
  run_command
      ->add_option("--order", run.order, "Order of the subteams: jacobi or gauss_seidel [gauss_seidel]")
      ->needs(partition);
  run_command->add_option("--exchanges", run.exchanges, "Exchanges of predictions per update [1]")
      ->needs(partition);

  fly_command = app.add_subcommand("fly", "Fly a fleet of real robots; write log, summary and report");
  add_fleet(*fly_command, fly.fleet);
  fly_command->add_option("-o,--output", fly.output, "Folder for the results [out/NAME]");
  const auto dry_run = fly_command->add_flag("--dry-run", fly.dry_run, "All but arm; writes nothing");
  fly_command->add_flag("--wait", fly.wait, "Take off when the service ~/start is called")->excludes(dry_run);
  fly_command->add_option("--part", fly.part,
                          "The part of [partition] that is planned here; all: one solver plans all");
  fly_command->add_option("--partition", fly.partition,
                          "Parts in place of those of [partition]: \"front: a,b | back: c,d\"");
  add_threads(*fly_command, fly.threads);
  add_show(*fly_command, fly.view)->excludes(dry_run);

  vehicles_command = app.add_subcommand("vehicles", "Simulate the robots of a fleet on their topics");
  add_fleet(*vehicles_command, vehicles.fleet);
  vehicles_command->add_option("--seconds", vehicles.seconds, "How long [s]; until Ctrl-C")
      ->check(CLI::Range(0.0, 1e9));

  doctor_command =
      app.add_subcommand("doctor", "Look at a fleet before a flight: green or red, a sentence each");
  add_fleet(*doctor_command, doctor.fleet);
  doctor_command->add_option("--seconds", doctor.seconds, "How long it listens [s] [10]")
      ->check(CLI::Range(1.0, 3600.0));
  doctor_command->add_flag("--watch", doctor.watch, "Print where each robot is, once a second, until Ctrl-C");
  doctor_command->add_flag("--json", doctor.json, "JSON instead of a table");

  check_command = app.add_subcommand("check", "Check a scenario and print what it describes");
  add_scenario(*check_command, check.scenario);
  check_command->add_flag("--print", check.expanded,
                          "Print the scenario with its templates and ranges expanded");
  check_command
      ->add_flag("--fix", check.fix, "First rewrite the file: keys and words that have another name now")
      ->excludes("--print")
      ->excludes("--set");

  report_command = app.add_subcommand("report", "Make report.html again from a run's files");
  report_command->add_option("DIR", folder, "Folder of a run")->required();

  view_command =
      app.add_subcommand("view", "Show a flight in the browser: a scenario in real time, or a run's log");
  add_scenario(*view_command, view.of, "SCENARIO", "Scenario file (TOML), or the folder of a run");
  add_serve(*view_command, view.serve);
  view_command->add_flag("--open", view.open, "Open the page in the browser");
  view_command->add_option("--speed", view.speed, "Simulated seconds per second [1]")
      ->check(CLI::Range(0.001, 1000.0));
  view_command->add_flag("--tune", view.tune, "Let those who look on change the flight, which is logged");
  view_command->add_option("-o,--output", view.output,
                           "Folder for the log of a tuned flight [out/NAME/tuned]");
  view_command->add_flag("--paused", view.paused, "Wait for Enter after the first period");
  view_command->add_option("--seconds", view.seconds, "How long the page is served [s]; until Ctrl-C")
      ->check(CLI::Range(0.0, 1e9));

  replay_command = app.add_subcommand("replay", "Fly a run's measurements again and compare its commands");
  replay_command->add_option("DIR", replay.folder, "Folder of a run")->required();
  replay_command->add_option("--solver", replay.solver, "Solver, instead of the flight's");
  add_set(*replay_command, replay.set);
  replay_command->add_flag("--json", replay.json, "JSON instead of a table");

  identify_command = app.add_subcommand(
      "identify", "Fit the model of a multirotor to a flight that excites it, or to a run");
  add_scenario(*identify_command, identify.of, "SCENARIO", "Scenario file (TOML), or the folder of a run");
  identify_command->add_option("--agent", identify.agent, "Robot [the only multirotor]");
  identify_command
      ->add_option("--excitation", identify.excitation, "steps, chirp, 3211 or bang_bang, in a scenario")
      ->capture_default_str();
  identify_command->add_option("--seconds", identify.seconds, "Time of the excitation [s]")
      ->capture_default_str();
  identify_command->add_option("--height", identify.height,
                               "Where it begins [m]; the scenario's, but at least 2 m");
  identify_command->add_option("--radius", identify.radius, "Farthest from the start, level [m]")
      ->capture_default_str();
  identify_command->add_option("--seed", identify.seed, "Seed of steps and noise, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  identify_command->add_option("-o,--output", identify.output,
                               "Folder for the results [out/NAME/identify; of a run, its own]");
  identify_command->add_flag("--json", identify.json, "JSON instead of a table");

  potential_command =
      app.add_subcommand("potential", "Draw and judge the potentials of a scenario's couplings");
  add_scenario(*potential_command, potential.scenario);
  potential_command->add_option("--couple", potential.couple, "One coupling, from 0 in the file's order");
  potential_command->add_option("-o,--output", potential.output,
                                "Folder for the results [out/NAME/potential]");

  explain_command =
      app.add_subcommand("explain", "Analyse which limits can hold together and what they cost");
  add_scenario(*explain_command, explain.scenario);

  campaign_command =
      app.add_subcommand("campaign", "Fly a scenario many times with random draws, [campaign]");
  CLI::Option* drawn =
      campaign_command->add_option("SCENARIO", campaign.scenario.file, "Scenario file (TOML)");
  add_set(*campaign_command, campaign.scenario.set);
  campaign_command->add_option("--runs", campaign.runs, "Number of runs")
      ->capture_default_str()
      ->check(CLI::Range(1, runs_max));
  campaign_command->add_option("--seed", campaign.seed, "Seed of all draws, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  campaign_command->add_option("--threads", campaign.threads, "Runs at the same time [all cores]")
      ->check(CLI::Range(1, 1024));
  campaign_command->add_option("-o,--output", campaign.output, "Folder for the results [out/NAME/campaign]");
  campaign_command->add_option("--only", campaign.only, "Fly this run alone, with log and report")
      ->check(CLI::Range(0, runs_max - 1));
  campaign_command->add_option("--compare-with", campaign.compare_with,
                               "Another scenario of the same robots, flown with the same draws");
  CLI::Option* shard =
      campaign_command
          ->add_option("--shard", campaign.shard, "Fly every N-th run alone, from run I on: \"3/8\"")
          ->excludes("--only");
  CLI::Option* resume =
      campaign_command
          ->add_flag("--resume", campaign.resume, "Go on with runs that are there; none is an error")
          ->excludes("--only");
  campaign_command
      ->add_option("--merge", campaign.merge, "Make one table and page of the folders of all shards")
      ->excludes(drawn)
      ->excludes(shard)
      ->excludes(resume)
      ->excludes("--only")
      ->excludes("--compare-with")
      ->excludes("--set")
      ->excludes("--runs")
      ->excludes("--seed")
      ->excludes("--threads");
  CLI::Option* slurm = campaign_command
                           ->add_flag("--slurm", campaign.slurm.submit,
                                      "Fly the shards as a job array of Slurm, wait, and merge them")
                           ->excludes(shard)
                           ->excludes(resume)
                           ->excludes("--only")
                           ->excludes("--threads")
                           ->excludes("--merge");
  campaign_command->add_flag("--dry-run", campaign.slurm.dry_run, "Print the job array's script, no more")
      ->needs(slurm);
  campaign_command->add_option("--shards", campaign.slurm.shards, "Shards of the job array")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000))
      ->needs(slurm);
  campaign_command
      ->add_option("--cpus", campaign.slurm.cpus, "Processors of each shard [SBATCH_CPUS_PER_TASK, or 1]")
      ->check(CLI::Range(1, 1024))
      ->needs(slurm);
  campaign_command
      ->add_option("--partition", campaign.slurm.partition, "Of Slurm [SBATCH_PARTITION, or its default]")
      ->needs(slurm);
  campaign_command
      ->add_option("--time", campaign.slurm.time,
                   "That a shard may take at most, as sbatch reads it [SBATCH_TIMELIMIT, or its default]")
      ->needs(slurm);

  parts_command = app.add_subcommand(
      "parts", "List the robots, potentials, references and limits that a scenario may use");
  parts_command->add_flag("--json", parts_as_json, "JSON instead of tables");

  version_command = app.add_subcommand("version", "Version and compiler");

  bench_command = app.add_subcommand("bench", "Time the solvers and compare them with the optimum");
  bench_command->add_option("--case", bench.name, "One case, instead of all");
  bench_command->add_option("--solver", bench.solver, "Solver [newton_riccati]");
  bench_command->add_flag("--json", bench.json, "JSON instead of a table");
  add_threads(*bench_command, bench.threads);
  bench_command
      ->add_option("--updates", bench.updates,
                   "Updates of each case; of swarm_N in whole crossings, events_8 has its own")
      ->capture_default_str()
      ->check(CLI::Range(100, 10'000'000));
  bench_command->add_flag("--times", bench.times_only, "Times alone, not compared with the optimum");
}

}  // namespace sightline::cli
