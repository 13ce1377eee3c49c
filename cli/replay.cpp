#include <fmt/format.h>

#include <algorithm>

#include "cli/arguments.hpp"
#include "cli/output.hpp"
#include "cli/partition.hpp"
#include "sightline/config.hpp"
#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline::cli {
namespace {

struct ReplayCommand {
  std::filesystem::path folder;
  std::optional<std::string> solver;
  std::vector<std::string> set;  ///< applied to the scenario in the log
  bool json = false;
};

/// The controllers of the flight: the solvers of its subteams, or those of the scenario.
class Steering {
 public:
  Steering(const Scenario& scenario, const FlownAs& flown, bool as_one) {
    if (flown.partition.empty() || as_one) {
      controls_.emplace(scenario);
      return;
    }
    subteams_.emplace(scenario, read_partition(scenario, flown.partition, flown.order, flown.exchanges));
  }
  Controllers controllers() {
    if (subteams_) return {*subteams_};
    return controls_->controllers();
  }
  TeamSwitcher* team_switcher() const { return controls_ ? controls_->team_switcher() : nullptr; }

 private:
  std::optional<Controls> controls_;
  std::optional<PartitionedFlight> subteams_;
};

std::string sentence(const FirstDifference& first) {
  return fmt::format("update {} at {:.6g} s: {} of {} = {}, recorded {}", first.update, first.time,
                     first.input, first.robot, first.replayed, first.recorded);
}

std::string sentence(const FirstEstimate& first) {
  return fmt::format("update {} at {:.6g} s: {} of the estimate of {} = {}, recorded {}", first.update,
                     first.time, first.what, first.robot, first.replayed, first.recorded);
}

void print_text(const CommandComparison& compared, const Scenario& scenario) {
  print("{}: {} updates, {} commands, {} differ\n", scenario.name, compared.updates(), compared.commands(),
        compared.differing());
  if (compared.estimates() > 0)
    print("{} estimates of poses, {} differ\n", compared.estimates(), compared.differing_estimates());
  if (const auto estimate = compared.first_estimate()) print("{}\n", sentence(*estimate));
  const auto first = compared.first();
  if (!first) return;
  print("{}\n", sentence(*first));
  std::size_t width = 5;
  for (const RobotDifference& robot : compared.robots()) width = std::max(width, robot.name.size());
  print("\n{:{}}  {:>9}  {:>12}  {:>10}  {:>12}\n", "robot", width, "differing", "largest", "at [s]", "rms");
  for (const RobotDifference& robot : compared.robots()) {
    if (robot.differing == 0) continue;
    print("{:{}}  {:>9}  {:>12.4g}  {:>10.6g}  {:>12.4g}\n", robot.name, width, robot.differing,
          robot.largest, robot.largest_at, robot.rms);
  }
  if (compared.other_status() > 0)
    print("another status in {} of {} updates\n", compared.other_status(), compared.updates());
}

int replay(const ReplayCommand& command, const Registry& registry) {
  const bool changed = command.solver || !command.set.empty();
  const std::filesystem::path log = log_of(command.folder);
  const FlownAs flown = flown_as(log);
  const Scenario scenario = flown_scenario(flown, log, registry, command.solver, command.set);
  RecordedFlight flight(log, scenario.team, scenario.x0, scenario.horizon.dt, scenario.goals);
  if (flown.version != sightline::version || flown.compiler != compiler) {
    print_sentence(fmt::format("the log is of sightline {} ({}), this is {} ({}): last bits may differ",
                               flown.version, flown.compiler, sightline::version, compiler));
  }
  if (flight.lost_after()) {
    print_sentence(
        fmt::format("samples were lost after {:.6g} s, what followed is not replayed", *flight.lost_after()));
  }
  if (flight.truncated())
    print_sentence(fmt::format("the log ends at {:.6g} s without its end", flight.periods().back().time));

  Steering steering(scenario, flown, command.solver.has_value());
  const Controllers controllers = steering.controllers();
  CommandComparison compared(flight, sized_sample(flight, controllers, steering.team_switcher()));
  ClosedLoop loop(scenario, flight, controllers, flight, compared, nullptr, steering.team_switcher());
  (void)loop.fly();

  if (command.json) {
    print("{}\n", comparison_json(compared, scenario, flight));
  } else {
    print_text(compared, scenario);
  }
  if (changed) return 0;
  return compared.differing() == 0 && compared.differing_estimates() == 0 && !flight.lost_after() ? 0 : 1;
}

}  // namespace

Execute describe_replay(CLI::App& app) {
  const auto command = std::make_shared<ReplayCommand>();
  app.description("Fly a run's measurements again and compare its commands");
  app.add_option("DIR", command->folder, "Folder of a run")->required();
  app.add_option("--solver", command->solver, "Solver, instead of the flight's");
  add_set(app, command->set);
  app.add_flag("--json", command->json, "JSON instead of a table");
  return [command](const Registry& registry, char**) {
    return refusing([&] { return replay(*command, registry); });
  };
}

}  // namespace sightline::cli
