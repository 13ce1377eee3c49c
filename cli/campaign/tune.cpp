#include "sightline/campaign/tune.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include "cli/arguments.hpp"
#include "cli/output.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario/layers.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;

struct TuneCommand {
  NamedScenario scenario;
  std::string measure;
  TuneOptions options;
  std::optional<std::uint64_t> seed;
  int threads = 0;  // 0: all cores
  fs::path output;
};

void print_weights(const TunedScenario& tuning) {
  std::size_t width = std::string_view("weight").size();
  for (const TunedWeight& weight : tuning.weights) width = std::max(width, weight.key.size());
  print("{:{}}  {:>10}  {:>10}\n", "weight", width, "before", "after");
  for (const TunedWeight& weight : tuning.weights)
    print("{:{}}  {:>10}  {:>10}\n", weight.key, width, weight.before, weight.after);
}

void print_measures(const TunedScenario& tuning, const TuneOptions& options) {
  const auto change = [](double before, double after) {
    return before > 0 ? fmt::format("{:+.1f} %", 100 * (after / before - 1)) : std::string("-");
  };
  print("\n{:24}  {:>10}  {:>10}  {:>9}  {:>10}  {:>10}  {:>9}\n", "", "draws", "after", "", "held out",
        "after", "");
  for (std::size_t m = 0; m < tune_measures.size(); ++m) {
    const double before = tuning.draws_before.measures[m], after = tuning.draws_after.measures[m];
    const double held_out = tuning.held_out_before.measures[m], then = tuning.held_out_after.measures[m];
    if (std::isnan(before)) continue;
    print("{:24}  {:>10.4g}  {:>10.4g}  {:>9}  {:>10.4g}  {:>10.4g}  {:>9}\n",
          fmt::format("{} [{}]", tune_measures[m], tune_units[m]), before, after, change(before, after),
          held_out, then, change(held_out, then));
  }
  const auto recovered = [](const TuneRuns& runs, int of) {
    return fmt::format("{} of {}", runs.recovered, of);
  };
  print("{:24}  {:>10}  {:>10}  {:>9}  {:>10}  {:>10}\n\n", "recovered",
        recovered(tuning.draws_before, options.draws), recovered(tuning.draws_after, options.draws), "",
        recovered(tuning.held_out_before, options.held_out),
        recovered(tuning.held_out_after, options.held_out));
}

int tune(const TuneCommand& command, const Registry& registry) {
  TuneOptions options = command.options;
  std::optional<Scenario> scenario;
  std::optional<FolderLock> lock;
  std::optional<TunedScenario> tuning;
  fs::path file;
  try {
    options.measure = tune_measure(command.measure);
    scenario = command.scenario.read(registry);
    options.seed = command.seed.value_or(scenario->simulation.seed);
    const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    options.threads = std::min(command.threads > 0 ? command.threads : cores, ThreadPool::most);
    const fs::path folder =
        command.output.empty() ? fs::path("out") / scenario->name / "tune" : command.output;
    file = folder / (scenario->name + ".toml");
    if (fs::exists(file))
      throw std::invalid_argument(fmt::format(
          "{}: is there already; give another folder by -o, or move the file away", file.native()));
    check_tune(*scenario, options);
    lock.emplace(folder, std::initializer_list<std::string_view>{"tune.json"});
    outlive_the_terminal();
    tuning = sightline::tune(*scenario, options, [](std::string_view sentence) { print_sentence(sentence); });
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
  print_weights(*tuning);
  print_measures(*tuning, options);
  const fs::path report = lock->folder() / "tune.json";
  write_text(report, tuning_json(*tuning, *scenario, options));
  print("{}\n", report.native());
  if (!tuning->accepted) {
    print_sentence(tuning->steps == 0
                       ? fmt::format("no step lowers {}: no scenario is written", command.measure)
                       : fmt::format("the measure of the held-out runs does not fall, or fewer recover: no "
                                     "scenario is written"));
    return 1;
  }
  write_text(file, text_seen_from(lock->folder(), tuning->text, scenario->file));
  print("{}\n", file.native());
  return 0;
}

}  // namespace

Execute describe_tune(CLI::App& app) {
  const auto command = std::make_shared<TuneCommand>();
  app.description("Adjust the weights of a scenario over the draws of its [campaign]");
  add_scenario(app, command->scenario);
  app.add_option("--for", command->measure,
                 "Measure to minimise: view_angle, view_excess or rms_position_error")
      ->required();
  app.add_option("--draws", command->options.draws, "Runs by which the weights are chosen")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  app.add_option("--held-out", command->options.held_out, "Further runs by which they are accepted")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  app.add_option("--steps", command->options.steps, "Steps at most")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  app.add_option("--factor", command->options.factor, "Greatest change of a weight")
      ->capture_default_str()
      ->check(CLI::Range(1.01, 1e6));
  app.add_option("--seed", command->seed, "Seed of all draws, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  app.add_option("--threads", command->threads, "Runs at the same time [all cores]")
      ->check(CLI::Range(1, ThreadPool::most));
  app.add_option("-o,--output", command->output, "Folder for the results [out/NAME/tune]");
  return [command](const Registry& registry, char**) { return tune(*command, registry); };
}

}  // namespace sightline::cli
