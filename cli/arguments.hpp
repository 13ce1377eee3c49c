/// Description of the command line: commands, options and the parsed values. The manual pages and
/// the shell completion are generated from it.
#pragma once

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"

namespace sightline::cli {

struct Arguments {
  Arguments();
  Arguments(const Arguments&) = delete;
  Arguments& operator=(const Arguments&) = delete;

  CLI::App app;
  RunOptions run;
  CheckCommand check;
  ExplainCommand explain;
  std::filesystem::path folder;
  bool parts_as_json = false;
  FlyCommand fly;
  VehiclesCommand vehicles;
  DoctorCommand doctor;
  ViewCommand view;
  ReplayCommand replay;
  IdentifyCommand identify;
  PotentialOptions potential;
  CampaignCommand campaign;
  BenchCommand bench;
  CLI::App *run_command, *fly_command, *vehicles_command, *doctor_command, *check_command, *report_command,
      *view_command, *replay_command, *identify_command, *potential_command, *explain_command,
      *campaign_command, *parts_command, *version_command, *bench_command;
};

}  // namespace sightline::cli
