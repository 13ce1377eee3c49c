#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <thread>

#include "cli/commands.hpp"
#include "cli/enter_key.hpp"
#include "cli/fleet.hpp"
#include "cli/linked_sink.hpp"
#include "cli/output.hpp"
#include "sightline/base.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/file_kind.hpp"
#include "sightline/server/flight_page.hpp"
#include "sightline/server/log_page.hpp"
#include "sightline/server/log_playback.hpp"
#include "sightline/server/paced_clock.hpp"
#include "sightline/server/page_files.hpp"

namespace sightline::cli {
namespace {

using Moments = std::chrono::steady_clock;

/// A sink that discards all samples.
class UnloggedSink final : public Sink<Sample> {
 public:
  explicit UnloggedSink(const Sample& prototype) : sample_(prototype) {}

  Sample* claim() noexcept override { return &sample_; }
  void publish() noexcept override {}
  void close() noexcept override {}

 private:
  Sample sample_;
};

void open_browser(const std::string& url) {
  std::array<std::string, 2> words = {"xdg-open", url};
  std::array<char*, 3> arguments = {words[0].data(), words[1].data(), nullptr};
  pid_t child = 0;
  if (::posix_spawnp(&child, words[0].c_str(), nullptr, nullptr, arguments.data(), environ) != 0)
    print_sentence("no xdg-open, expected one that opens the page: open it by hand");
}

void announce(const ViewCommand& command, const std::string& url) {
  print_without_page();
  print("{}\n", url);
  if (command.open) open_browser(url);
}

void wait_until(Moments::time_point end) {
  while (!stop_flight() && Moments::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

int view_log(const ViewCommand& command, const Registry& registry, const ServeOptions& options) {
  const std::filesystem::path &folder = command.of.file, log = log_of(folder);
  if (!command.of.set.empty() || command.speed || command.paused || command.tune || !command.output.empty())
    throw std::invalid_argument(
        "--set, --speed, --paused, --tune and --output of a log, expected none: it is flown already");
  const auto scenario_of_log = [&] {
    const FlownAs flown = flown_as(log);
    Scenario scenario = parse_scenario(flown.text, log, registry, {.files = flown.files});
    scenario.name = flown.name;
    scenario.solver.name = flown.solver;
    return scenario;
  };
  const auto end = end_of(command);
  LogPlayback playback(log, scenario_of_log());
  const LogPage page(folder, scenario_of_log, options, &playback.feed());
  announce(command, page.url());
  wait_until(end);
  report_counts(page.counts());
  return 0;
}

int view_flight(const ViewCommand& command, const Registry& registry, const ServeOptions& options) {
  if (command.tune)
    return view_tuned(command, registry, [&](const std::string& url) { announce(command, url); });
  if (!command.output.empty())
    throw std::invalid_argument("--output, expected beside --tune alone: view writes no files");
  Scenario scenario = command.of.read(registry);
  scenario.simulation.compare.clear();
  lift_deadline(scenario.solver);
  check_solvers(scenario);
  const auto end = end_of(command);
  std::atomic<bool>& stop = stop_flight();
  PacedClock clock(command.speed.value_or(1.0), command.paused, stop);
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  const Sample prototype = sized_sample(*world, controls.controllers(), controls.team_switcher());
  FlightPage page(scenario, prototype, options);
  UnloggedSink unlogged(prototype);
  ShownSink sink(unlogged, page);
  ClosedLoop loop(scenario, *world, controls.controllers(), clock, sink, nullptr, controls.team_switcher(),
                  &stop);
  announce(command, page.url());
  LoopOutcome outcome;
  {
    std::optional<EnterKey> enter;
    if (command.paused) {
      print_sentence("paused, Enter flies on");
      enter.emplace(clock, stop);
    }
    ServiceThread timer("the end of the view", [&] {
      wait_until(end);
      stop = true;
    });
    try {
      run_apart([&] { outcome = loop.fly(); });
    } catch (...) {
      stop = true;  // no flight is left that a view could wait for
      throw;
    }
    if (!stop) print_sentence("the flight is over, the page stays until Ctrl-C");
    timer.join();
  }
  report_counts(page.counts());
  if (page.dropped() > 0) print_sentence(fmt::format("{} samples were not shown", page.dropped()));
  if (outcome.finite) return 0;
  const std::string why = world->ended();
  print_sentence(why.empty() ? "a state or an input was not finite" : why);
  return 1;
}

}  // namespace

Moments::time_point end_of(const ViewCommand& command) {
  return Moments::now() +
         std::chrono::duration_cast<Moments::duration>(std::chrono::duration<double>(command.seconds));
}

void report_counts(const ServeCounts& counts) {
  if (counts.unrequested > 0)
    print_sentence(
        fmt::format("{} messages that would change the flight were refused: it is not tuned (--tune)",
                    counts.unrequested));
  print_sentence(
      fmt::format("{} connections, {} refused; {} states sent, {} left out for slow ones, {} watchers closed",
                  counts.connections, counts.refused, counts.sent, counts.dropped, counts.closed));
  if (counts.messages + counts.messages_dropped > 0)
    print_sentence(fmt::format("{} messages of topics sent, {} left out for slow ones", counts.messages,
                               counts.messages_dropped));
}

void print_without_page() {
  if (!has_page()) print_sentence(without_page(page_lacks()) + ": only data are served");
}

int view(const ViewCommand& command, const Registry& registry) {
  const ServeOptions& options = command.serve;
  outlive_the_terminal();
  listen_to_interrupts();
  std::error_code ignored;  // the reading reports the error of an inaccessible file
  try {
    return std::filesystem::is_directory(command.of.file, ignored) ? view_log(command, registry, options)
                                                                   : view_flight(command, registry, options);
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
}

}  // namespace sightline::cli
