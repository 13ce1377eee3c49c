#include "sightline/record/log.hpp"

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <iterator>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/config.hpp"
#include "sightline/record/log_topics.hpp"
#include "sightline/record/team_json.hpp"
#include "sightline/record/tuned_log.hpp"

namespace sightline {
namespace {

const std::filesystem::path& prepared(const std::filesystem::path& folder) {
  std::error_code ignored;  // opening the files reports the error
  std::filesystem::create_directories(folder, ignored);
  std::filesystem::remove(beside(folder / "run.mcap"), ignored);
  return folder;
}

// Removes results of an earlier run that this run writes only at its end, or never.
void remove_results(const std::filesystem::path& folder, const std::vector<std::string>& solvers) {
  std::error_code ignored;
  for (const char* name : {"summary.json", "report.html", "partition.json", "whole/summary.json"})
    std::filesystem::remove(folder / name, ignored);
  for (const std::string& solver : solvers)  // of comparisons
    std::filesystem::remove(folder / solver / "summary.json", ignored);
}

}  // namespace

class Log::Files {
 public:
  Files(const Scenario& scenario, const std::filesystem::path& folder, std::size_t controllers,
        std::function<void(double)> written, const McapWords& flown);
  ~Files() {
    if (!taken_) remove_parts();
  }

  void take(const Sample& sample) noexcept;
  void end() noexcept;

  const Summary& summary() const { return summary_; }
  std::string error() const;
  bool begun() const { return begun_; }

 private:
  void begin();
  void remove_parts() noexcept;
  void add(const Sample& sample);
  void report_written(double time) noexcept;
  void add_timing(const Sample& sample);

  double period_;  // [s]
  std::function<void(double)> written_;
  Summary summary_;
  std::vector<std::string> solvers_;  // names of all
  std::filesystem::path folder_;
  McapWriter mcap_;
  std::optional<LogTopics> topics_;
  TextFile timing_;

  double last_ = 0.0;  // time of the last sample [s]
  bool taken_ = false, begun_ = false, added_ = false;

  // Exceptions of judging and of writing, each with the time before it [s].
  struct Fault {
    std::exception_ptr what;
    double after = 0.0;
  } judging_, writing_;

  std::string rows_;
};

Log::Files::Files(const Scenario& scenario, const std::filesystem::path& folder, std::size_t controllers,
                  std::function<void(double)> written, const McapWords& flown)
    : period_(scenario.horizon.dt),
      written_(std::move(written)),
      summary_(scenario, controllers),
      folder_(prepared(folder)),
      mcap_(beside(folder_ / "run.mcap"), "ros2", fmt::format("sightline {}", version)),
      timing_(folder_ / "timing.csv") {
  McapWords words = {{"name", scenario.name},
                     {"scenario", scenario.text},
                     {"version", std::string(version)},
                     {"compiler", std::string(compiler)},
                     {"solver", scenario.solver.name},
                     {"seed", fmt::format("{}", scenario.simulation.seed)},
                     {"period", fmt::format("{}", period_)},
                     {"controllers", fmt::format("{}", controllers)},
                     {"team", team_json(scenario)}};
  words.insert(flown.begin(), flown.end());
  for (const std::string_view solver : solver_names(registry_of(scenario))) solvers_.emplace_back(solver);
  if (scenario.tuned) words.emplace(TunedLog::word, "true");
  mcap_.metadata("sightline", words);
  if (!scenario.files.empty()) mcap_.metadata("files", scenario.files);
  topics_.emplace(scenario, controllers, mcap_);
  rows_ = "time,update_us";
  for (std::size_t c = 0; c < controllers; ++c)
    rows_ += controllers > 1 ? fmt::format(",solve_us.controller{}", c) : ",solve_us";
  rows_ += ",allocations,iterations,missed\n";
}

// With the first sample the log replaces that of an earlier run, whose results no longer match.
void Log::Files::begin() {
  timing_.write(std::exchange(rows_, {}));
  if (!mcap_.ok() || !timing_.error().empty()) return remove_parts();
  remove_results(folder_, solvers_);
  timing_.settle();
  mcap_.settle(folder_ / "run.mcap");
  begun_ = mcap_.ok();
}

void Log::Files::remove_parts() noexcept {
  std::error_code ignored;
  for (const char* name : {"run.mcap", "timing.csv"})
    std::filesystem::remove(beside(folder_ / name), ignored);
}

// Any failure of judging or writing is kept, because the flight stops if nothing drains the queue.
void Log::Files::take(const Sample& sample) noexcept {
  try {
    if (!judging_.what) summary_.add(sample);
  } catch (...) {
    judging_ = {std::current_exception(), last_};
  }
  try {
    if (!std::exchange(taken_, true)) begin();
    if (!writing_.what) add(sample);
  } catch (...) {
    writing_.what = std::current_exception();
  }
  last_ = sample.time;
}

void Log::Files::add(const Sample& sample) {
  if (sample.of == Sample::Of::states) return topics_->add_states(sample);
  const double cost = judging_.what ? std::numeric_limits<double>::quiet_NaN() : summary_.stage_cost();
  const bool ends_chunk = topics_->add(sample, summary_.present(), cost);
  add_timing(sample);
  if (!ends_chunk) return;
  mcap_.flush();
  timing_.write(rows_);
  rows_.clear();
  added_ = true;
  writing_.after = sample.time;
  report_written(sample.time);
}

void Log::Files::report_written(double time) noexcept {
  if (!written_ || !mcap_.ok() || !timing_.error().empty()) return;
  try {
    written_(time);
  } catch (...) {
    written_ = nullptr;  // the receiver has failed
  }
}

void Log::Files::add_timing(const Sample& sample) {
  const auto row = std::back_inserter(rows_);
  fmt::format_to(row, "{},{:.3f}", sample.time, sample.update_us);
  std::int64_t allocations = 0, iterations = 0, missed = 0;
  for (const SolverRecord& record : sample.solvers) {
    fmt::format_to(row, ",{:.3f}", record.solve_us);
    allocations += record.allocations;
    iterations += record.iterations;
  }
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[size(i)];
    if (event.kind == EventKind::missed_period) missed += std::llround(event.value);
  }
  fmt::format_to(row, ",{},{},{}\n", allocations, iterations, missed);
}

void Log::Files::end() noexcept {
  try {
    if (!writing_.what) mcap_.close();
    timing_.write(rows_);
    timing_.close();
  } catch (...) {
    writing_.what = std::current_exception();
  }
  if (writing_.what) {
    mcap_.abandon();
  } else if (added_) {
    report_written(last_ + period_);
  }
}

std::string Log::Files::error() const {
  const auto describe = [](const std::exception_ptr& what) -> std::string {
    try {
      std::rethrow_exception(what);
    } catch (const std::exception& error) {
      return sentence_of(error);
    } catch (...) {
    }
    return "an exception without words";
  };
  if (!mcap_.ok()) return mcap_.error();
  if (!timing_.error().empty()) return timing_.error();
  if (writing_.what)
    return fmt::format("{}: what came after {:.6g} s is lost: {}", (folder_ / "run.mcap").native(),
                       writing_.after, describe(writing_.what));
  if (judging_.what)
    return fmt::format("{}: what came after {:.6g} s is not judged: {}", (folder_ / "summary.json").native(),
                       judging_.after, describe(judging_.what));
  return {};
}

Log::Log(const Scenario& scenario, const std::filesystem::path& folder, const Controllers& controllers,
         SpscQueue<Sample>& ring, std::function<void(double)> written, const McapWords& flown)
    : ring_(ring),
      files_(std::make_unique<Files>(scenario, folder, controllers.size(), std::move(written), flown)) {}

Log::~Log() {
  ring_.close();
  finish();
}

void Log::start() {
  thread_.start(
      [this] {
        while (const Sample* sample = ring_.wait()) {
          files_->take(*sample);
          ring_.pop();
        }
        files_->end();
      },
      [this] { ring_.abandon(); });
}

void Log::finish() { thread_.join(); }

std::string Log::error() const { return thread_.failed() ? std::string(thread_.failure()) : files_->error(); }
bool Log::begun() const { return files_->begun(); }
const Summary& Log::summary() const { return files_->summary(); }

}  // namespace sightline
