#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <list>
#include <map>
#include <span>
#include <stdexcept>
#include <thread>

#include "cli/arguments.hpp"
#include "cli/campaign/slurm.hpp"
#include "cli/output.hpp"
#include "cli/progress.hpp"
#include "sightline/analysis.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/campaign/certify.hpp"
#include "sightline/campaign/evasion_page.hpp"
#include "sightline/campaign/merge.hpp"
#include "sightline/campaign/page.hpp"
#include "sightline/campaign/paired.hpp"
#include "sightline/campaign/result_file.hpp"
#include "sightline/campaign/table.hpp"
#include "sightline/scenario/renamed.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;

constexpr int runs_max = 1'000'000'000;
constexpr int rare_runs_min = 200;

/// The checked input of the command.
struct Input {
  std::vector<Scenario> scenarios;  // its own, then the one to compare with
  CampaignPlan plan;
  CampaignOptions options;
  fs::path folder;
  bool resumes = false;  // the folder must contain runs already

  int runs() const { return options.shard.size(options.runs); }

  /// Folder of one of the scenarios: the one to compare with has a subfolder.
  fs::path folder_of(std::size_t i) const { return i == 0 ? folder : folder / scenarios[i].name; }
};

Input read(const CampaignCommand& command, const Registry& registry) {
  Input input;
  if (command.scenario.file.empty())
    throw std::invalid_argument(
        "SCENARIO is missing, expected a scenario file (TOML), or --merge and the folders of shards");
  const Scenario& scenario = input.scenarios.emplace_back(command.scenario.read(registry));
  input.plan = campaign_plan(scenario);
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  input.options = {.runs = command.runs,
                   .seed = command.seed.value_or(scenario.simulation.seed),
                   .threads = command.threads > 0 ? command.threads : cores,
                   .shard = command.shard.empty() ? Shard{} : shard_of(command.shard)};
  const fs::path own = fs::path("out") / scenario.name;
  const fs::path alone = command.only ? own / fmt::format("run_{}", *command.only) : own / "campaign";
  input.folder = command.output.empty() ? alone : command.output;
  input.resumes = command.resume;
  if (!command.compare_with.empty())
    input.scenarios.push_back(read_scenario(command.compare_with, registry, command.scenario.set));
  for (const Scenario& one : input.scenarios) check_campaign(one, input.plan);
  return input;
}

using Counts = std::array<int, outcome_count>;

/// The tables of all scenarios, in folders that this process locks.
struct Tables {
  explicit Tables(const Input& input) {
    for (std::size_t i = 0; i < input.scenarios.size(); ++i)
      locks.emplace_back(input.folder_of(i),
                         std::initializer_list<std::string_view>{"campaign.sqlite", "campaign.json",
                                                                 "campaign.html", "certificate.json"});
    for (std::size_t i = 0; i < input.scenarios.size(); ++i) open(input, i);
  }

  std::list<FolderLock> locks;
  std::list<RunTable> runs;

 private:
  void open(const Input& input, std::size_t i) {
    const Scenario& scenario = input.scenarios[i];
    const fs::path file = input.folder_of(i) / "campaign.sqlite";
    if (input.resumes && !fs::exists(file))
      throw std::invalid_argument(fmt::format("{}: is missing, expected runs to --resume", file.native()));
    RunTable& table = runs.emplace_back(file, scenario, input.plan, input.options.seed, input.options.shard,
                                        input.options.runs);
    if (table.rows() == 0) return;
    check_continues(table, file, scenario, input.plan, input.options);
    if (table.rows() < input.runs())
      print_sentence(fmt::format("{}: goes on after {} runs", file.native(), table.rows()));
  }
};

/// Flies the runs that the table lacks.
Counts fly_all(const Scenario& scenario, const Input& input, RunTable& table) {
  Counts counts{};
  for (int i = 0; i < outcome_count; ++i)
    counts[static_cast<std::size_t>(i)] = table.rows(static_cast<Outcome>(i));
  CampaignOptions options = input.options;
  options.first = table.rows();
  int done = options.first;
  CampaignProgress progress(scenario.name, input.runs(), done, counts[0]);
  fly_campaign(scenario, input.plan, options, [&](const RunDraw& run, const RunResult& result) {
    table.add(run, result);
    ++counts[static_cast<std::size_t>(result.outcome)];
    progress.show(++done, counts[0]);
  });
  table.finish();
  return counts;
}

/// The command that repeats a run of this campaign, without its index and folder.
std::string again(const CampaignCommand& command, const Input& input) {
  std::string words = fmt::format("sightline campaign {} --seed {}",
                                  shell_word(command.scenario.file.native()), input.options.seed);
  for (const std::string& assignment : command.scenario.set) words += " --set " + shell_word(assignment);
  if (!command.compare_with.empty()) words += " --compare-with " + shell_word(command.compare_with.native());
  return words;
}

void print_lines(const std::vector<CampaignLine>& lines) {
  for (const CampaignLine& line : lines) print("{:24}  {}\n", line.what, line.value);
}

/// Prints a scenario compared with the first one, run by run.
void print_compared(const CampaignTable& first, const CampaignTable& beside) {
  print("\n{}, compared with {}\n", beside.name, first.name);
  print_lines(energy_lines(first, beside));
}

/// The row of a run as text.
std::string words_of(const RunDraw& run, const RunResult& result, const CampaignPlan& plan) {
  std::string words = fmt::format("run {}: {}", run.index, to_string(result.outcome));
  if (std::isfinite(result.time_to_first_view)) {
    words += fmt::format(", first view {:.2f} s, in view {:.1f} % of the time", result.time_to_first_view,
                         100 * result.fraction_in_view);
  } else if (std::isfinite(result.fraction_in_view)) {
    words += ", never in view";
  }
  if (std::isfinite(result.min_distance))
    words += fmt::format(", least distance {:.3f} m", result.min_distance);
  if (result.barrier_conflict > 0)
    words += fmt::format(", barrier in conflict {:.1f} % of the time", 100 * result.barrier_conflict);
  for (const RobotView& view : result.views)
    if (std::isfinite(view.certified))
      words += fmt::format(", view of {} by {} certified {:.1f} % of the time", view.target, view.observer,
                           100 * view.certified);
  if (!result.reason.empty()) words += fmt::format("\n{:24}  {}", "failed by", result.reason);
  words += '\n';
  const std::vector<std::string> names = drawn_names(plan);
  for (std::size_t i = 0; i < names.size(); ++i) words += fmt::format("{:24}  {}\n", names[i], run.values[i]);
  return words;
}

/// Flies one run of each scenario, as `sightline run` does; the drawn scenario is written beside
/// the log.
int fly_one(const Input& input, int index) {
  const RunDraw run = draw_run(input.plan, input.options.seed, index);
  std::list<RunFolder> folders;
  for (std::size_t i = 0; i < input.scenarios.size(); ++i)
    folders.emplace_back(input.folder_of(i), Variants(input.scenarios[i], input.plan).of(run));
  int code = 0;
  for (std::size_t i = 0; i < input.scenarios.size(); ++i) {
    const Variants variants(input.scenarios[i], input.plan);
    const RunResult result = RunWorker(variants, input.plan).fly(run);
    Scenario scenario = variants.of(run, folders.front().path());
    write_text(folders.front().path() / (scenario.name + ".toml"), scenario.text);
    print("{}", words_of(run, result, input.plan));
    SimulatedClock clock;
    const int flown = fly(std::move(scenario), folders.front(), clock);
    folders.pop_front();
    if (i == 0) code = result.outcome == Outcome::recovered ? flown : 1;
  }
  return code;
}

/// The names of the compared scenarios, by their subfolders.
std::vector<std::string> names_beside(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (fs::exists(entry.path() / "campaign.sqlite")) names.push_back(entry.path().filename().native());
  std::sort(names.begin(), names.end());
  return names;
}

std::string describe(const std::vector<std::string>& names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

/// Returns the scenario of the shards and the files it names, by their paths in a folder from which
/// it can be flown again. A file outside that folder keeps its name and is not copied.
std::map<fs::path, std::string> scenario_files(const CampaignWords& about, const fs::path& folder) {
  std::map<fs::path, std::string> files = {{folder / (about.scenario + ".toml"), about.text}};
  for (const auto& [name, text] : about.files) {
    const fs::path place = fs::path(name).lexically_normal();
    if (place.is_relative() && *place.begin() != "..")
      files.emplace(folder / place, text);
    else
      print_sentence(fmt::format("{} lies outside of the scenario's folder: it is not written into {}", name,
                                 folder.native()));
  }
  for (const auto& [file, text] : files)
    if (fs::exists(file) && read_text(file) != text)
      throw std::invalid_argument(fmt::format(
          "{}: is there already and is not that of the shards; give another folder by -o, or move the file "
          "away",
          file.native()));
  return files;
}

/// Merges the folders of all shards into one table and page, including the compared scenarios.
int merge(const CampaignCommand& command, const Registry& registry) {
  const std::vector<fs::path>& from = command.merge;
  const auto tables_in = [&](const fs::path& inside) {
    std::vector<fs::path> tables;
    for (const fs::path& folder : from) tables.push_back(folder / inside / "campaign.sqlite");
    return tables;
  };
  const CampaignWords about = campaign_words(from.front() / "campaign.sqlite");
  const std::vector<std::string> beside = names_beside(from.front());
  for (const fs::path& folder : from)
    if (fs::is_directory(folder) && names_beside(folder) != beside)
      throw std::invalid_argument(fmt::format(
          "{}: holds other scenarios beside its own than {}, expected the same: {} and {}", folder.native(),
          from.front().native(), describe(names_beside(folder)), describe(beside)));

  const fs::path out =
      command.output.empty() ? fs::path("out") / about.scenario / "campaign" : command.output;
  const fs::path scenario_file = out / (about.scenario + ".toml");
  const FolderLock lock(out, {"campaign.json", "campaign.html"});
  const auto files = scenario_files(about, out);
  merge_shards(tables_in(""), out / "campaign.sqlite");
  for (const auto& [file, text] : files) {
    fs::create_directories(file.parent_path());
    write_text(file, text);
  }
  std::vector<CampaignTable> tables = {{about.scenario, out / "campaign.sqlite"}};
  for (const std::string& name : beside) {
    fs::create_directories(out / name);
    merge_shards(tables_in(name), out / name / "campaign.sqlite");
    tables.push_back({name, out / name / "campaign.sqlite"});
  }
  write_machines(out, machines_of(from));
  write_text(out / "campaign.json", campaign_json(tables, machines_of({out})));
  for (const CampaignTable& table : tables) {
    const CampaignWords words = campaign_words(table.file);
    print("{}{}: {} runs of {} shards, seed {}\n", &table == &tables.front() ? "" : "\n", words.scenario,
          words.runs, from.size(), words.seed);
    print_lines(campaign_lines(table));
    if (&table != &tables.front()) print_compared(tables.front(), table);
  }
  int code = 0;
  for (const CampaignTable& table : tables)
    if (const CampaignWords words = campaign_words(table.file); words.recovered < words.runs) code = 1;
  try {
    // The scenario with the [campaign] that draws; the table holds the files of its own scenario
    // only.
    const auto parsed = [&](const std::string& text, const ScenarioChanges& changes) {
      return parse_scenario(with_present_names(text, scenario_file.native()).text, scenario_file, registry,
                            changes);
    };
    const Scenario scenario =
        about.plan.empty() ? parsed(about.text, {.files = about.files}) : parsed(about.plan, {});
    const std::string words =
        fmt::format("sightline campaign {} --seed {}", shell_word(scenario_file.native()), about.seed);
    write_text(out / "campaign.html", campaign_html(tables, campaign_plan(scenario), words, out));
    print("{}\n", (out / "campaign.html").native());
  } catch (const std::exception& error) {  // e.g. on a full disk: the table holds all flown runs
    print_sentence(sentence_of(error));
    code = 1;
  }
  for (const char* file : {"campaign.json", "campaign.sqlite"}) print("{}\n", (out / file).native());
  return code;
}

/// Flies all shards by Slurm, then merges them into one table and page.
int campaign_by_slurm(const CampaignCommand& command, const Input& input, const Registry& registry) {
  const std::string script =
      slurm_script(command, input.options.seed, input.scenarios.front().name, input.folder);
  if (command.slurm.dry_run) {
    print("{}", script);
    return 0;
  }
  const int shards = command.slurm.shards;
  outlive_the_terminal();
  fs::create_directories(input.folder);
  if (!fly_by_slurm(script, shards, input.folder)) return 1;
  CampaignCommand of_shards = command;
  of_shards.output = input.folder;
  for (int i = 1; i <= shards; ++i) of_shards.merge.push_back(shard_folder(input.folder, i));
  return merge(of_shards, registry);
}

int campaign(const CampaignCommand& command, const Registry& registry) {
  Input input;
  try {
    if (!command.merge.empty()) return merge(command, registry);
    input = read(command, registry);
    if (command.slurm.submit) return campaign_by_slurm(command, input, registry);
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
  outlive_the_terminal();
  Counts counts{};
  bool lost = false;
  try {
    if (command.only) return fly_one(input, *command.only);
    Tables held(input);
    note_machine(input.folder, this_machine());
    std::vector<CampaignTable> tables;
    for (std::size_t i = 0; i < input.scenarios.size(); ++i) {
      const Scenario& scenario = input.scenarios[i];
      const Counts of_this = fly_all(scenario, input, held.runs.front());
      held.runs.pop_front();
      if (i == 0) counts = of_this;
      tables.push_back({scenario.name, input.folder_of(i) / "campaign.sqlite"});
      print("{}{}: {} runs, seed {}{}\n", i > 0 ? "\n" : "", scenario.name, input.runs(), input.options.seed,
            input.options.shard.is_whole() ? "" : ", shard " + to_string(input.options.shard));
      print_lines(campaign_lines(tables.back()));
      if (i == 0) continue;
      print_compared(tables[0], tables.back());
    }
    std::vector<EvasionRuns> evasions;
    for (std::size_t i = 0; input.plan.evasion && input.options.shard.is_whole() && i < tables.size(); ++i)
      evasions.push_back(
          evasion_runs(input.scenarios[i], input.plan, input.options.seed, input.options.runs));
    if (input.plan.evasion) print("\n{}\n", evasion_text(*input.plan.evasion, evasions));
    std::string bounds;
    std::error_code ignored;
    fs::remove(input.folder / "certificate.json", ignored);  // of other runs
    if (command.certify > 0) {
      const Certificate certificate =
          certify(input.scenarios.front(), input.plan, tables.front(), input.options, command.certify);
      print("\n");
      print_lines(certificate_lines(certificate));
      write_text(input.folder / "certificate.json", certificate_json(certificate));
      bounds = certificate_html(certificate);
    }
    write_text(input.folder / "campaign.json", campaign_json(tables, machines_of({input.folder})));
    for (std::size_t i = 0; i < tables.size(); ++i) {
      const std::vector<CampaignTable> shown = i == 0 ? tables : std::vector<CampaignTable>{tables[i]};
      const std::span of_all(evasions);
      const auto of_page = i == 0 || evasions.empty() ? of_all : of_all.subspan(i, 1);
      try {
        write_text(input.folder_of(i) / "campaign.html",
                   campaign_html(shown, input.plan, again(command, input), input.folder,
                                 (i == 0 ? bounds : "") +
                                     (input.plan.evasion ? evasion_html(*input.plan.evasion, of_page) : "")));
      } catch (const std::runtime_error& error) {  // e.g. on a full disk: the table holds all flown runs
        print_sentence(sentence_of(error));
        lost = true;
      }
    }
  } catch (const ScenarioError& error) {
    print_message("{}\n", error.what());
    return 2;
  } catch (const std::invalid_argument& error) {
    print_message("{}\n", error.what());
    return 2;
  }
  for (const char* file : {"campaign.html", "campaign.json", "campaign.sqlite", "certificate.json"})
    if (std::error_code error; fs::exists(input.folder / file, error))
      print("{}\n", (input.folder / file).native());
  if (counts[0] == input.runs()) return lost ? 1 : 0;
  for (int i = 1; i < outcome_count; ++i) {
    if (const int bad = counts[static_cast<std::size_t>(i)]; bad > 0)
      print_sentence(fmt::format("{} of {} runs: {}", bad, input.runs(), to_string(static_cast<Outcome>(i))));
  }
  return 1;
}

}  // namespace

Execute describe_campaign(CLI::App& app) {
  const auto command = std::make_shared<CampaignCommand>();
  app.description("Fly a scenario many times with random draws, [campaign]");
  CLI::Option* drawn = app.add_option("SCENARIO", command->scenario.file, "Scenario file (TOML)");
  add_set(app, command->scenario.set);
  app.add_option("--runs", command->runs, "Number of runs")
      ->capture_default_str()
      ->check(CLI::Range(1, runs_max));
  app.add_option("--seed", command->seed, "Seed of all draws, instead of the scenario's")
      ->check(CLI::Range(std::uint64_t{0}, seed_max));
  app.add_option("--threads", command->threads, "Runs at the same time [all cores]")
      ->check(CLI::Range(1, 1024));
  app.add_option("-o,--output", command->output, "Folder for the results [out/NAME/campaign]");
  app.add_option("--only", command->only, "Fly this run alone, with log and report")
      ->check(CLI::Range(0, runs_max - 1));
  app.add_option("--compare-with", command->compare_with,
                 "Another scenario of the same robots, flown with the same draws");
  CLI::Option* shard =
      app.add_option("--shard", command->shard, "Fly every N-th run alone, from run I on: \"3/8\"")
          ->excludes("--only");
  CLI::Option* resume =
      app.add_flag("--resume", command->resume, "Go on with runs that are there; none is an error")
          ->excludes("--only");
  app.add_option("--merge", command->merge, "Make one table and page of the folders of all shards")
      ->excludes(drawn, shard, resume, "--only", "--compare-with", "--set", "--runs", "--seed", "--threads");
  CLI::Option* slurm = app.add_flag("--slurm", command->slurm.submit,
                                    "Fly the shards as a job array of Slurm, wait, and merge them")
                           ->excludes(shard, resume, "--only", "--threads", "--merge");
  // Not the number itself: CLI11 2.4 checks the default of a flag that is a number in every command.
  app.add_flag_function(
         "--certify{2000}", [command](std::int64_t runs) { command->certify = static_cast<int>(runs); },
         "Bound the probabilities of lost views and broken distances, with so many more runs of each")
      ->check(CLI::Range(rare_runs_min, runs_max))
      ->multi_option_policy(CLI::MultiOptionPolicy::Throw)
      ->excludes(shard, slurm, "--only", "--merge");
  app.add_flag("--dry-run", command->slurm.dry_run, "Print the job array's script, no more")->needs(slurm);
  app.add_option("--shards", command->slurm.shards, "Shards of the job array")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000))
      ->needs(slurm);
  app.add_option("--cpus", command->slurm.cpus, "Processors of each shard [SBATCH_CPUS_PER_TASK, or 1]")
      ->check(CLI::Range(1, 1024))
      ->needs(slurm);
  app.add_option("--partition", command->slurm.partition, "Of Slurm [SBATCH_PARTITION, or its default]")
      ->needs(slurm);
  app.add_option("--time", command->slurm.time,
                 "That a shard may take at most, as sbatch reads it [SBATCH_TIMELIMIT, or its default]")
      ->needs(slurm);
  return [command](const Registry& registry, char**) { return campaign(*command, registry); };
}

}  // namespace sightline::cli
