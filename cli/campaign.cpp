#include "sightline/campaign/campaign.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <span>
#include <thread>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/campaign/evasion_page.hpp"
#include "sightline/campaign/page.hpp"
#include "sightline/campaign/paired.hpp"
#include "sightline/campaign/table.hpp"
#include "sightline/io/page.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;

void say(std::string_view sentence) { fmt::print(stderr, "sightline: {}\n", sentence); }

/// How far a campaign is: a line that is written anew on a terminal, and else one every tenth of the runs.
class ProgressLine {
 public:
  ProgressLine(std::string name, int runs)
      : terminal_(isatty(STDERR_FILENO) == 1), name_(std::move(name)), runs_(runs) {}
  ~ProgressLine() {
    if (terminal_ && shown_) fmt::print(stderr, "\n");
  }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(int done, int recovered) {
    const auto now = Time::now();
    const bool due = terminal_ ? now >= next_ || done == runs_ : 10 * (done - 1) / runs_ < 10 * done / runs_;
    if (!due) return;
    next_ = now + std::chrono::milliseconds(100);
    shown_ = true;
    const double elapsed = std::chrono::duration<double>(now - begin_).count();
    fmt::print(stderr, "{}{}: {} of {} runs, {} recovered, {:.0f} s left{}", terminal_ ? "\r" : "", name_,
               done, runs_, recovered, elapsed * (runs_ - done) / done, terminal_ ? "   " : "\n");
    std::fflush(stderr);
  }

 private:
  using Time = std::chrono::steady_clock;
  bool terminal_, shown_ = false;
  std::string name_;
  int runs_;
  Time::time_point begin_ = Time::now(), next_ = begin_;
};

/// All that the command is about, read and checked.
struct Input {
  std::vector<Scenario> scenarios;  // its own, and the one beside it
  CampaignPlan plan;
  CampaignOptions options;
  fs::path folder;

  /// Of one of the scenarios: that beside has a folder within the folder.
  fs::path folder_of(std::size_t i) const { return i == 0 ? folder : folder / scenarios[i].name; }
};

Input read(const CampaignCommand& command) {
  Input input;
  const Scenario& scenario = input.scenarios.emplace_back(read_scenario(command.scenario));
  if (!scenario.campaign) {
    throw std::invalid_argument(fmt::format(
        "{}:1: campaign is missing, expected [campaign] with what is drawn", scenario.file.native()));
  }
  input.plan = *scenario.campaign;
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  input.options = {.runs = command.runs,
                   .seed = command.seed.value_or(scenario.simulation.seed),
                   .threads = command.threads > 0 ? command.threads : cores};
  const fs::path own = fs::path("out") / scenario.name;
  const fs::path alone = command.only ? own / fmt::format("run_{}", *command.only) : own / "campaign";
  input.folder = command.output.empty() ? alone : command.output;
  if (!command.beside.empty()) input.scenarios.push_back(read_scenario(command.beside));
  for (const Scenario& one : input.scenarios) {
    if (changes_in_flight(one)) {
      throw std::invalid_argument(
          fmt::format("{}: the team changes in flight, expected one that stays: a campaign judges one team",
                      one.file.native()));
    }
    Variants(one, input.plan);
  }
  for (std::size_t i = 0; i < input.scenarios.size(); ++i) make_folder(input.folder_of(i));
  return input;
}

using Counts = std::array<int, outcome_count>;

/// Flies all runs of one scenario into campaign.sqlite.
Counts fly_all(const Scenario& scenario, const Input& input, const fs::path& folder) {
  RunTable table(folder / "campaign.sqlite", scenario, input.plan, input.options.seed);
  Counts counts{};
  ProgressLine progress(scenario.name, input.options.runs);
  int done = 0;
  fly_campaign(scenario, input.plan, input.options, [&](const RunDraw& run, const RunResult& result) {
    table.add(run, result);
    ++counts[static_cast<std::size_t>(result.outcome)];
    progress.show(++done, counts[0]);
  });
  table.finish();
  return counts;
}

/// What flies a run of this campaign again, but for its index and folder.
std::string again(const CampaignCommand& command, const Input& input) {
  std::string words =
      fmt::format("sightline campaign {} --seed {}", command.scenario.native(), input.options.seed);
  if (!command.beside.empty()) words += fmt::format(" --beside {}", command.beside.native());
  return words;
}

void print_lines(const std::vector<CampaignLine>& lines) {
  for (const CampaignLine& line : lines) fmt::print("{:24}  {}\n", line.what, line.value);
}

/// What a run's row says.
std::string words_of(const RunDraw& run, const RunResult& result, const CampaignPlan& plan) {
  std::string words =
      fmt::format("run {}: {}, first view {:.2f} s, in view {:.1f} % of the time, least distance {:.3f} m\n",
                  run.index, to_string(result.outcome), result.time_to_first_view,
                  100 * result.fraction_in_view, result.min_distance);
  const std::vector<std::string> names = drawn_names(plan);
  for (std::size_t i = 0; i < names.size(); ++i) words += fmt::format("{:24}  {}\n", names[i], run.values[i]);
  return words;
}

/// One run of each scenario, as `sightline run` flies it; its own scenario lies beside the log.
int fly_one(const Input& input, int index) {
  const RunDraw run = draw_run(input.plan, input.options.seed, index);
  int code = 0;
  for (std::size_t i = 0; i < input.scenarios.size(); ++i) {
    const Variants variants(input.scenarios[i], input.plan);
    const RunResult result = Pilot(variants, input.plan).fly(run);
    Scenario scenario = variants.of(run);
    const fs::path folder = input.folder_of(i);
    write_text(folder / (scenario.name + ".toml"), scenario.text);
    fmt::print("{}", words_of(run, result, input.plan));
    SimulatedClock clock;
    const int flown = fly(std::move(scenario), folder, clock);
    if (i == 0) code = result.outcome == Outcome::recovered ? flown : 1;
  }
  return code;
}

}  // namespace

int campaign(const CampaignCommand& command) {
  Input input;
  try {
    input = read(command);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  Counts counts{};
  try {
    if (command.only) return fly_one(input, *command.only);
    std::vector<CampaignTable> tables;
    for (std::size_t i = 0; i < input.scenarios.size(); ++i) {
      const Scenario& scenario = input.scenarios[i];
      const fs::path folder = input.folder_of(i);
      const Counts of_this = fly_all(scenario, input, folder);
      if (i == 0) counts = of_this;
      tables.push_back({scenario.name, folder / "campaign.sqlite"});
      fmt::print("{}{}: {} runs, seed {}\n", i > 0 ? "\n" : "", scenario.name, input.options.runs,
                 input.options.seed);
      print_lines(campaign_lines(tables.back()));
      if (i == 0) continue;
      fmt::print("\n{}, compared with {}\n", scenario.name, tables[0].name);
      print_lines(energy_lines(tables[0], tables.back()));
    }
    std::vector<EvasionRuns> evasions;
    for (std::size_t i = 0; input.plan.evasion && i < tables.size(); ++i)
      evasions.push_back(
          evasion_runs(input.scenarios[i], input.plan, input.options.seed, input.options.runs));
    if (input.plan.evasion) fmt::print("\n{}\n", evasion_text(*input.plan.evasion, evasions));
    for (std::size_t i = 0; i < tables.size(); ++i) {
      const std::vector<CampaignTable> shown = i == 0 ? tables : std::vector<CampaignTable>{tables[i]};
      const std::span of_all(evasions);
      const auto of_page = i == 0 || evasions.empty() ? of_all : of_all.subspan(i, 1);
      write_text(input.folder_of(i) / "campaign.html",
                 campaign_html(shown, input.plan, again(command, input), input.folder,
                               input.plan.evasion ? evasion_html(*input.plan.evasion, of_page) : ""));
    }
  } catch (const ScenarioError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  for (const char* file : {"campaign.html", "campaign.sqlite"})
    fmt::print("{}\n", (input.folder / file).native());
  if (counts[0] == input.options.runs) return 0;
  for (int i = 1; i < outcome_count; ++i) {
    if (const int bad = counts[static_cast<std::size_t>(i)]; bad > 0)
      say(fmt::format("{} of {} runs: {}", bad, input.options.runs, to_string(static_cast<Outcome>(i))));
  }
  return 1;
}

}  // namespace sightline::cli
