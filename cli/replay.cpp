#include "sightline/record/replay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "cli/partition.hpp"
#include "sightline/base/version.hpp"
#include "sightline/scenario/closed_loop.hpp"

namespace sightline::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Whether what is set is of the solver.
bool sets_solver(const std::vector<std::string>& assignments) {
  return std::any_of(assignments.begin(), assignments.end(), [](std::string_view assignment) {
    const std::string_view key = assignment.substr(0, assignment.find_first_of(".= "));
    return key == "solver";
  });
}

/// The scenario of the log, as it was flown, or with what the command changes.
Scenario scenario_of(const FlownAs& flown, const std::filesystem::path& log, const ReplayCommand& command,
                     const Parts& parts) {
  Scenario scenario = parse_scenario(flown.text, log, parts, {.files = flown.files, .set = command.set});
  scenario.name = flown.name;
  const bool in_parts = !flown.partition.empty();
  if (command.solver) {
    if (*command.solver != scenario.solver.name) scenario.solver = solver_named(*command.solver);
  } else if (!in_parts && flown.solver != scenario.solver.name && !sets_solver(command.set)) {
    scenario.solver = solver_named(flown.solver);
  }
  lift_deadline(scenario.solver);
  scenario.simulation.compare.clear();
  check_solvers(scenario);
  return scenario;
}

/// What the flight was steered by: its subteams' solvers, or as the scenario says.
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

Json as_json(const CommandComparison& compared, const Scenario& scenario, const RecordedFlight& flight) {
  Json json = {{"scenario", scenario.name},
               {"solver", scenario.solver.name},
               {"updates", compared.updates()},
               {"commands", compared.commands()},
               {"differing", compared.differing()},
               {"other_status", compared.other_status()},
               {"complete", !flight.truncated() && !flight.lost_after()}};
  const auto first = compared.first();
  json["first"] = !first ? Json() : Json{{"update", first->update},     {"time", first->time},
                                         {"robot", first->robot},       {"input", first->input},
                                         {"recorded", first->recorded}, {"replayed", first->replayed}};
  if (compared.estimates() > 0) {
    const auto estimate = compared.first_estimate();
    json["estimates"] = {{"compared", compared.estimates()}, {"differing", compared.differing_estimates()}};
    json["estimates"]["first"] =
        !estimate ? Json() : Json{{"update", estimate->update},     {"time", estimate->time},
                                  {"robot", estimate->robot},       {"what", estimate->what},
                                  {"recorded", estimate->recorded}, {"replayed", estimate->replayed}};
  }
  json["robots"] = Json::array();
  for (const RobotDifference& robot : compared.robots()) {
    json["robots"].push_back({{"name", robot.name},
                              {"differing", robot.differing},
                              {"largest", robot.largest},
                              {"largest_at", robot.largest_at},
                              {"rms", robot.rms}});
  }
  return json;
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

}  // namespace

int replay(const ReplayCommand& command, const Parts& parts) {
  const std::filesystem::path log = command.folder / "run.mcap";
  const bool changed = command.solver || !command.set.empty();
  try {
    if (!std::filesystem::is_regular_file(log)) {
      tell("{}: no run.mcap, expected the folder of a run\n", command.folder.native());
      return 2;
    }
    const FlownAs flown = flown_as(log);
    const Scenario scenario = scenario_of(flown, log, command, parts);
    RecordedFlight flight(log, scenario.team, scenario.x0, scenario.horizon.dt, goals_of(scenario.fleet));
    if (flown.version != sightline::version || flown.compiler != compiler) {
      say(fmt::format("the log is of sightline {} ({}), this is {} ({}): last bits may differ", flown.version,
                      flown.compiler, sightline::version, compiler));
    }
    if (flight.lost_after()) {
      say(fmt::format("samples were lost after {:.6g} s, what followed is not replayed",
                      *flight.lost_after()));
    }
    if (flight.periods().empty()) return 1;
    if (flight.truncated())
      say(fmt::format("the log ends at {:.6g} s without its end", flight.periods().back().time));

    Steering steering(scenario, flown, command.solver.has_value());
    const Controllers controllers = steering.controllers();
    CommandComparison compared(flight, sized_sample(flight, controllers));
    ClosedLoop loop(scenario, flight, controllers, flight, compared, nullptr, steering.team_switcher());
    (void)loop.fly();

    if (command.json) {
      print("{}\n", as_json(compared, scenario, flight).dump(2));
    } else {
      print_text(compared, scenario);
    }
    if (changed) return 0;
    return compared.differing() == 0 && compared.differing_estimates() == 0 && !flight.lost_after() ? 0 : 1;
  } catch (const std::exception& error) {
    tell("{}\n", error.what());
    return 2;
  }
}

}  // namespace sightline::cli
