#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "cli/commands.hpp"
#include "cli/enter_key.hpp"
#include "cli/fleet.hpp"
#include "cli/linked_sink.hpp"
#include "cli/output.hpp"
#include "sightline/base.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "sightline/server/flight_page.hpp"
#include "sightline/server/paced_clock.hpp"
#include "sightline/server/tuning.hpp"

namespace sightline::cli {
namespace {

using TunedClock = std::chrono::steady_clock;

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
  /// @param serve  address of its page; updated with the actual address once the page is served
  TunedFlight(Scenario scenario, const std::filesystem::path& folder, const ViewCommand& command, bool paused,
              ServeOptions& serve)
      : scenario_(std::move(scenario)),
        folder_(folder, scenario_),
        clock_(command.speed.value_or(1.0), paused, over_),
        controls_(scenario_),
        tuning_(scenario_, {.clock = &clock_,
                            .restart =
                                [this](std::uint64_t seed) {
                                  seed_ = seed;
                                  again_ = over_ = true;
                                }}),
        serve_(serve) {}

  /// @param announce  receives the address of the page
  /// @return the exit code
  int fly(TunedClock::time_point end, const std::function<void(const std::string&)>& announce) {
    FlightOptions options{.team_switcher = controls_.team_switcher(), .stop = &over_};
    options.watched = [&](Sink<Sample>& log, const Sample& prototype) -> Sink<Sample>& {
      page_.emplace(scenario_, prototype, serve_, &tuning_);
      serve_ = page_->served();
      announce(page_->url());
      return sink_.emplace(log, *page_);
    };
    std::optional<EnterKey> enter;
    if (clock_.paused()) {
      print_sentence("paused, Enter or the page flies on");
      enter.emplace(clock_, over_);
    }
    ServiceThread timer("the end of the view", [&] {
      wait(end);
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
  void wait(TunedClock::time_point end) const {
    while (!stop_flight() && !again_ && TunedClock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  void report_of(const ServeCounts& counts) const {
    report_counts(counts);
    const std::size_t events = scenario_.tuned->size();
    print_sentence(fmt::format("{} changes, {} messages refused, {} not received", events, tuning_.refused(),
                               tuning_.stale()));
    if (page_->dropped() > 0) print_sentence(fmt::format("{} samples were not shown", page_->dropped()));
  }

  Scenario scenario_;
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

}  // namespace

int view_tuned(const ViewCommand& command, const Registry& registry,
               const std::function<void(const std::string&)>& announce) {
  const auto end = end_of(command);
  ServeOptions serve = command.serve;
  Scenario scenario = made_to_be_tuned(command.of.read(registry));
  int code = 0;
  for (int number = 1;; ++number) {
    TunedFlight flight(scenario, folder_of(command, scenario, number), command, number == 1 && command.paused,
                       serve);
    code = std::max(code, flight.fly(
                              end, number == 1 ? announce : [](const std::string&) {}));
    if (!flight.again()) return code;
    scenario = made_to_be_tuned(flight.next());
  }
}

}  // namespace sightline::cli
