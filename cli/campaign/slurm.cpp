#include "cli/campaign/slurm.hpp"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "cli/output.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/campaign/page.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds between_looks{1};
constexpr int looks_unanswered = 30;  // failed squeue calls before giving up

struct ShellResult {
  int code;
  std::string text;
};

/// Runs a shell command; returns its output, including errors.
ShellResult run_shell(const std::string& command) {
  const auto close = [](FILE* pipe) { ::pclose(pipe); };
  std::unique_ptr<FILE, decltype(close)> pipe(::popen((command + " 2>&1").c_str(), "r"), close);
  if (!pipe) throw std::runtime_error(fmt::format("{}: cannot be started", command));
  std::string text;
  std::array<char, 4096> piece{};
  while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), pipe.get()))
    text.append(piece.data(), n);
  const int status = ::pclose(pipe.release());
  while (text.ends_with('\n')) text.pop_back();
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 1, text};
}

std::string last_line(const fs::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last;
}

/// Number of waiting and running tasks of a job; none if Slurm gives no answer.
struct Tasks {
  int waiting = 0, running = 0;
};
std::optional<Tasks> tasks_of(const std::string& job) {
  const ShellResult result = run_shell(fmt::format("squeue --noheader --array --job {} --format %t", job));
  // Slurm reports a job it has forgotten as invalid: no task of the job is left.
  if (result.code != 0 && result.text.find("Invalid job id") == std::string::npos) return std::nullopt;
  Tasks tasks;
  std::size_t begin = 0;
  while (result.code == 0 && begin < result.text.size()) {
    const std::size_t end = std::min(result.text.find('\n', begin), result.text.size());
    (result.text.substr(begin, end - begin).starts_with("PD") ? tasks.waiting : tasks.running) += 1;
    begin = end + 1;
  }
  return tasks;
}

void wait_for(const std::string& job, int shards) {
  int unanswered = 0;
  std::string reported;
  for (;;) {
    const std::optional<Tasks> tasks = tasks_of(job);
    if (!tasks && ++unanswered > looks_unanswered)
      throw std::runtime_error(
          fmt::format("squeue does not report the state of job {}, expected a Slurm that answers; the same "
                      "command goes on from what is there",
                      job));
    if (tasks) {
      unanswered = 0;
      const std::string line =
          fmt::format("job {}: {} of {} shards over, {} fly, {} wait", job,
                      shards - tasks->waiting - tasks->running, shards, tasks->running, tasks->waiting);
      if (line != reported) print_sentence(line);
      reported = line;
      if (tasks->waiting + tasks->running == 0) return;
    }
    std::this_thread::sleep_for(between_looks);
  }
}

}  // namespace

fs::path shard_folder(const fs::path& folder, int shard) { return folder / fmt::format("shard_{}", shard); }

std::string slurm_script(const CampaignCommand& command, std::uint64_t seed, const std::string& name,
                         const fs::path& folder) {
  const SlurmOptions& options = command.slurm;
  const char* const of_environment = std::getenv("SBATCH_CPUS_PER_TASK");
  const int from_environment = of_environment != nullptr ? std::atoi(of_environment) : 0;
  const int cpus = options.cpus > 0 ? options.cpus : std::max(1, from_environment);
  const fs::path at = fs::absolute(folder).lexically_normal();
  const auto line = [](std::string_view what, const std::string& value) {
    return value.empty() ? std::string() : fmt::format("#SBATCH --{}={}\n", what, value);
  };
  std::string words = fmt::format("{} campaign {} --runs {} --seed {} --threads {}",
                                  shell_word(fs::read_symlink("/proc/self/exe").native()),
                                  shell_word(fs::absolute(command.scenario.file).lexically_normal().native()),
                                  command.runs, seed, cpus);
  for (const std::string& assignment : command.scenario.set) words += " --set " + shell_word(assignment);
  if (!command.compare_with.empty())
    words += " --compare-with " + shell_word(fs::absolute(command.compare_with).lexically_normal().native());
  return fmt::format(
             "#!/bin/bash\n#SBATCH --job-name=sightline-{}\n#SBATCH --array=1-{}\n#SBATCH --ntasks=1\n", name,
             options.shards) +
         line("cpus-per-task", std::to_string(cpus)) + line("partition", options.partition) +
         line("time", options.time) + line("output", (at / "shard_%a" / "slurm.txt").native()) +
         fmt::format(
             "{} --shard \"$SLURM_ARRAY_TASK_ID/{}\" -o {}/shard_\"$SLURM_ARRAY_TASK_ID\"\n"
             "echo \"exit $?\"\n",
             words, options.shards, shell_word(at.native()));
}

bool fly_by_slurm(const std::string& script, int shards, const fs::path& folder) {
  for (int i = 1; i <= shards; ++i) {
    fs::create_directories(shard_folder(folder, i));
    fs::remove(shard_folder(folder, i) / "slurm.txt");  // of an earlier job
  }
  const fs::path file = folder / "slurm.sh";
  write_text(file, script);
  const ShellResult submitted = run_shell("sbatch --parsable " + shell_word(file.native()));
  if (submitted.code != 0)
    throw std::runtime_error(fmt::format(
        "{}, expected a Slurm that takes {}",
        submitted.text.empty() ? "sbatch: no output" : submitted.text.substr(submitted.text.rfind('\n') + 1),
        file.native()));
  const std::string job = submitted.text.substr(0, submitted.text.find(';'));
  print_sentence(
      fmt::format("job {}: {} shards; scancel {} ends it, the same command goes on from what is there", job,
                  shards, job));
  wait_for(job, shards);
  bool all = true;
  for (int i = 1; i <= shards; ++i) {
    const fs::path result = shard_folder(folder, i) / "slurm.txt";
    const std::string last = last_line(result);
    // Runs that are not recovered are results too.
    if (last == "exit 0" || last == "exit 1") continue;
    all = false;
    print_sentence(fmt::format("shard {}/{} failed: {} ({})", i, shards,
                               last.empty()                ? "it left no word"
                               : last.starts_with("exit ") ? "it ended with " + last
                                                           : last,
                               result.native()));
  }
  return all;
}

}  // namespace sightline::cli
