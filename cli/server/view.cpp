#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "cli/arguments.hpp"
#include "cli/fleet.hpp"
#include "cli/linked_sink.hpp"
#include "cli/output.hpp"
#include "sightline/base.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/file_kind.hpp"
#include "sightline/server/certificate_file.hpp"
#include "sightline/server/flight_page.hpp"
#include "sightline/server/log_page.hpp"
#include "sightline/server/log_playback.hpp"
#include "sightline/server/paced_clock.hpp"
#include "sightline/server/page_files.hpp"
#include "sightline/server/tuning.hpp"

namespace sightline::cli {
namespace {

using Moments = std::chrono::steady_clock;

struct ViewCommand {
  NamedScenario of;
  ServeOptions serve{.port = page_port};
  bool open = false, paused = false, tune = false;
  std::optional<double> speed;
  std::filesystem::path output, certificate;
  double seconds = 1e9;
};

/// Shows each sample on a page.
class ShownSink : public WatchingSink {
 public:
  ShownSink(Sink<Sample>& sink, FlightPage& page) : WatchingSink(sink), page_(page) {}

 private:
  void watch(const Sample& sample) noexcept override { page_.show(sample); }

  FlightPage& page_;
};

void print_without_page() {
  if (!has_page()) print_sentence(without_page(page_lacks()) + ": only data are served");
}

/// Shows a flight on a page of its own.
class PageSink final : public ShownSink {
 public:
  PageSink(Sink<Sample>& sink, const Scenario& scenario, const Sample& prototype, const ServeOptions& options)
      : ShownSink(sink, page_),
        tuning_(scenario.tuned ? std::make_unique<Tuning>(scenario, TuningControls{}) : nullptr),
        page_(scenario, prototype, options, tuning_.get()) {
    print_without_page();
    print_sentence(fmt::format("the page is {}", page_.url()));
  }

 private:
  std::unique_ptr<Tuning> tuning_;  // null: the page is read-only
  FlightPage page_;
};

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

/// Resumes a paused flight when the user presses Enter.
class EnterKey {
 public:
  EnterKey(PacedClock& clock, std::atomic<bool>& stop)
      : thread_("the Enter key", [this, &clock, &stop] {
          pollfd typed{STDIN_FILENO, POLLIN, 0};
          while (!done_ && !stop && clock.paused()) {
            if (::poll(&typed, 1, 100) <= 0) continue;
            char key = 0;
            if (::read(STDIN_FILENO, &key, 1) != 1) return;
            if (key == '\n') clock.resume();
          }
        }) {}
  ~EnterKey() {
    done_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> done_{false};
  ServiceThread thread_;
};

/// Time at which the page closes, unless it is closed earlier.
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

void open_browser(const std::string& url) {
  std::array<std::string, 2> words = {"xdg-open", url};
  std::array<char*, 3> arguments = {words[0].data(), words[1].data(), nullptr};
  pid_t child = 0;
  if (::posix_spawnp(&child, words[0].c_str(), nullptr, nullptr, arguments.data(), environ) != 0)
    print_sentence("no xdg-open, expected one that opens the page: open it by hand");
}

/// The certificate beside a flight of the scenario; none if the command has none.
PageFile certificate_of(const ViewCommand& command, const Scenario& scenario) {
  return command.certificate.empty() ? no_certificate()
                                     : certificate_file(command.certificate, scenario.name);
}

void announce(const ViewCommand& command, const std::string& url) {
  print_without_page();
  print("{}\n", url);
  if (command.open) open_browser(url);
}

/// Waits until the user ends the view, `over` or the time `end`.
void wait_until(Moments::time_point end, const std::atomic<bool>& over = stop_flight()) {
  while (!stop_flight() && !over && Moments::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

/// Output folder of the first, second, ... flight.
std::filesystem::path folder_of(const ViewCommand& command, const Scenario& scenario, int number) {
  std::filesystem::path folder =
      command.output.empty() ? std::filesystem::path("out") / scenario.name / "tuned" : command.output;
  if (number > 1) folder += fmt::format("-{}", number);
  return folder;
}

/// The scenario of the next flight, with the tuned values and another seed.
Scenario with_seed(const Scenario& before, const Tuning& tuning, std::uint64_t seed) {
  const PageFiles files = tuning.files();
  const PageFile& values = files.at("/final.toml");
  const bool has_values = values.type.starts_with("application/toml");
  if (!has_values) {
    std::string_view why = values.body;
    if (why.starts_with("# ")) why.remove_prefix(2);
    print_sentence(fmt::format("the other flight has the scenario's own values: {}", why));
  }
  Scenario next = parse_scenario(has_values ? values.body : before.text, before.file, *before.registry,
                                 {.files = before.files, .set = {fmt::format("simulation.seed={}", seed)}});
  next.name = before.name;
  return next;
}

/// One flight with its page, from its start until a user ends it or requests another flight.
class TunedFlight {
 public:
  /// @param number  of the flight; the first may be paused, and announces the page
  /// @param serve  address of its page; updated with the actual address once the page is served
  TunedFlight(Scenario scenario, const ViewCommand& command, int number, ServeOptions& serve)
      : command_(command),
        number_(number),
        scenario_(std::move(scenario)),
        certificate_(certificate_of(command, scenario_)),
        folder_(folder_of(command, scenario_, number), scenario_),
        clock_(command.speed.value_or(1.0), number == 1 && command.paused, over_),
        controls_(scenario_),
        tuning_(scenario_, {.clock = &clock_,
                            .restart =
                                [this](std::uint64_t seed) {
                                  seed_ = seed;
                                  again_ = over_ = true;
                                }}),
        serve_(serve) {}

  /// @return the exit code
  int fly(Moments::time_point end) {
    FlightOptions options{.team_switcher = controls_.team_switcher(), .stop = &over_};
    options.watched = [&](Sink<Sample>& log, const Sample& prototype) -> Sink<Sample>& {
      page_.emplace(scenario_, prototype, serve_, &tuning_);
      page_->put(certificate_path, certificate_);
      serve_ = page_->served();
      if (number_ == 1) announce(command_, page_->url());
      return sink_.emplace(log, *page_);
    };
    std::optional<EnterKey> enter;
    if (clock_.paused()) {
      print_sentence("paused, Enter or the page flies on");
      enter.emplace(clock_, over_);
    }
    ServiceThread timer("the end of the view", [&] {
      wait_until(end, again_);
      over_ = true;
    });
    LoggedFlight flight;
    try {
      flight = fly_logged(scenario_, folder_.path(), clock_, controls_.controllers(), options);
    } catch (...) {
      again_ = true;
      timer.join();
      throw;
    }
    tuning_.end();
    if (!over_) print_sentence("the flight is over, the page stays until Ctrl-C");
    timer.join();
    for (const std::string& fault : flight.faults) print_sentence(fault);
    if (flight.logged) print_sentence(fmt::format("logged in {}", folder_.path().native()));
    report_of(page_->counts());
    return flight.outcome.finite && flight.logged ? 0 : 1;
  }

  bool again() const { return again_ && !stop_flight(); }
  Scenario next() const { return with_seed(scenario_, tuning_, seed_); }

 private:
  void report_of(const ServeCounts& counts) const {
    report_counts(counts);
    const std::size_t events = scenario_.tuned->size();
    print_sentence(fmt::format("{} changes, {} messages refused, {} not received", events, tuning_.refused(),
                               tuning_.stale()));
    if (page_->dropped() > 0) print_sentence(fmt::format("{} samples were not shown", page_->dropped()));
  }

  const ViewCommand& command_;
  int number_;
  Scenario scenario_;
  PageFile certificate_;
  RunFolder folder_;
  std::atomic<bool> over_{false}, again_{false};
  std::atomic<std::uint64_t> seed_{0};
  PacedClock clock_;
  const Controls controls_;
  Tuning tuning_;
  ServeOptions& serve_;
  std::optional<FlightPage> page_;
  std::optional<ShownSink> sink_;
};

Scenario made_to_be_tuned(Scenario scenario) {
  lift_deadline(scenario.solver);
  make_tunable(scenario);
  return scenario;
}

/// Flies flights that users of the page may change and restart with another seed; each writes its
/// log.
int view_tuned(const ViewCommand& command, const Registry& registry) {
  const auto end = end_of(command);
  ServeOptions serve = command.serve;
  Scenario scenario = made_to_be_tuned(command.of.read(registry));
  int code = 0;
  for (int number = 1;; ++number) {
    TunedFlight flight(scenario, command, number, serve);
    code = std::max(code, flight.fly(end));
    if (!flight.again()) return code;
    scenario = made_to_be_tuned(flight.next());
  }
}

int view_log(const ViewCommand& command, const Registry& registry) {
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
  const Scenario scenario = scenario_of_log();
  PageFile certificate = certificate_of(command, scenario);
  LogPlayback playback(log, scenario);
  LogPage page(folder, scenario_of_log, command.serve, &playback.feed());
  page.put(certificate_path, std::move(certificate));
  announce(command, page.url());
  wait_until(end);
  report_counts(page.counts());
  return 0;
}

int view_flight(const ViewCommand& command, const Registry& registry) {
  if (command.tune) return view_tuned(command, registry);
  if (!command.output.empty())
    throw std::invalid_argument("--output, expected beside --tune alone: view writes no files");
  Scenario scenario = command.of.read(registry);
  scenario.simulation.compare.clear();
  lift_deadline(scenario.solver);
  check_solvers(scenario);
  PageFile certificate = certificate_of(command, scenario);
  const auto end = end_of(command);
  std::atomic<bool>& stop = stop_flight();
  PacedClock clock(command.speed.value_or(1.0), command.paused, stop);
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  const Sample prototype = sized_sample(*world, controls.controllers(), controls.team_switcher());
  FlightPage page(scenario, prototype, command.serve);
  page.put(certificate_path, std::move(certificate));
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

int view(const ViewCommand& command, const Registry& registry) {
  outlive_the_terminal();
  listen_to_interrupts();
  std::error_code ignored;  // the reading reports the error of an inaccessible file
  return std::filesystem::is_directory(command.of.file, ignored) ? view_log(command, registry)
                                                                 : view_flight(command, registry);
}

}  // namespace

std::unique_ptr<Sink<Sample>> show_on_page(Sink<Sample>& log, const Scenario& scenario,
                                           const Sample& prototype, const ServeOptions& options) {
  return std::make_unique<PageSink>(log, scenario, prototype, options);
}

Execute describe_view(CLI::App& app) {
  const auto command = std::make_shared<ViewCommand>();
  app.description("Show a flight in the browser: a scenario in real time, or a run's log");
  add_scenario(app, command->of, "SCENARIO", "Scenario file (TOML), or the folder of a run");
  add_serve(app, command->serve);
  app.add_option("--certificate", command->certificate,
                 "Folder of a campaign with --certify, whose bounds are shown beside the flight");
  app.add_flag("--open", command->open, "Open the page in the browser");
  app.add_option("--speed", command->speed, "Simulated seconds per second [1]")
      ->check(CLI::Range(0.001, 1000.0));
  app.add_flag("--tune", command->tune, "Let those who look on change the flight, which is logged");
  app.add_option("-o,--output", command->output, "Folder for the log of a tuned flight [out/NAME/tuned]");
  app.add_flag("--paused", command->paused, "Wait for Enter after the first period");
  app.add_option("--seconds", command->seconds, "How long the page is served [s]; until Ctrl-C")
      ->check(CLI::Range(0.0, 1e9));
  return [command](const Registry& registry, char**) {
    return refusing([&] { return view(*command, registry); });
  };
}

}  // namespace sightline::cli
