#include "sightline/scenario/read_estimate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <variant>

#include "sightline/base.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/scenario/read_coupling.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 2> localization_kinds = {"global", "vision"};
constexpr std::array<std::string_view, 2> cycle_words = {"refused", "intersection"};
constexpr std::string_view correlation_key = "correlation_time";

/// The bodies with tags that a robot observes with its cameras at some time of a run.
std::vector<BodyId> observed_by(BodyId robot, const ScenarioSpec& scenario) {
  std::vector<BodyId> all;
  const auto add = [&](BodyId body) {
    if (scenario.vision.tags_of(body) != nullptr && std::find(all.begin(), all.end(), body) == all.end())
      all.push_back(body);
  };
  const auto add_coupling = [&](const Coupling& c) {
    if (c.between.first == robot && observes(c.term.potential) &&
        scenario.vision.camera_of(robot, c.term.potential.mount()) != nullptr)
      add(c.between.second);
  };
  for (const Coupling& c : scenario.team.couplings()) add_coupling(c);
  for (const TeamEvent& event : scenario.script.events) {
    for (const Action& action : event.actions) {
      if (const auto* added = std::get_if<AddCoupling>(&action)) add_coupling(added->coupling);
      if (const auto* turn = std::get_if<HandOver>(&action)) {
        for (const Coupling& c : turn->couplings) add_coupling(c);
      }
      if (const auto* observe = std::get_if<Observe>(&action))
        if (observe->observer == robot) add(observe->target);
    }
  }
  return all;
}

std::vector<BodyId> read_observed(const TomlTable& agent, BodyId robot, const ScenarioSpec& scenario) {
  constexpr std::string_view key = "observes";
  std::vector<BodyId> read = bodies_named(agent, key, TomlTable::any_length, scenario.team);
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (read[i] == robot) agent.throw_invalid(key, i, "another body than itself");
    if (std::find(read.begin(), read.begin() + static_cast<std::ptrdiff_t>(i), read[i]) !=
        read.begin() + static_cast<std::ptrdiff_t>(i))
      agent.throw_invalid(key, i, "each body once");
    if (scenario.vision.tags_of(read[i]) == nullptr)
      agent.throw_invalid(key, i, fmt::format("a body with tags, {} has none", scenario.team.name(read[i])));
  }
  return read;
}

/// Reads a robot that is localized by its camera.
LocalizedRobot read_localized(const TomlTable& agent, BodyId robot, const FilterOptions& filter,
                              const ScenarioSpec& scenario) {
  constexpr std::string_view key = "localization";
  const RobotCamera* const camera = scenario.vision.camera_of(robot);
  if (camera == nullptr)
    agent.throw_invalid(key, fmt::format("\"global\", or a robot with a camera, [{}.camera]", agent.path()));
  LocalizedRobot read{.robot = robot,
                      .mount = camera->mount,
                      .observes = agent.has("observes") ? read_observed(agent, robot, scenario)
                                                        : observed_by(robot, scenario),
                      .filter = filter,
                      .camera_rate = 0.0};
  int cameras = 0;
  for (const RobotCamera& one : scenario.vision.cameras)
    if (one.observer == robot) ++cameras, read.camera_rate += one.camera.rate;
  if (cameras > 1 && filter.camera_turn > 0)
    agent.throw_invalid(key, "\"global\", or a robot with one camera, whose turn camera_turn estimates");
  if (read.observes.empty())
    agent.throw_invalid(
        key,
        "\"global\", or a coupling by which it observes a body with tags, or such bodies under "
        "observes");
  return read;
}

/// Rejects a vision-localized robot whose sensors do not measure its heading.
void refuse_unknown_headings(const TomlTable& at, const ScenarioSpec& scenario) {
  const SensedTeam team = sensed_team(scenario);
  for (const Unobservable& what : unobservable_states(team.robots, team.places, team.sightings))
    if (what.heading) at.checked([&] { throw_invalid("{}", to_string(what, team.robots)); });
}

}  // namespace

bool sees_headings(const ScenarioSpec& scenario, BodyId observer) {
  const auto& cameras = scenario.vision.cameras;
  return std::all_of(cameras.begin(), cameras.end(), [&](const RobotCamera& one) {
    return one.observer != observer || one.camera.output == CameraOutput::pose;
  });
}

SensedTeam sensed_team(const ScenarioSpec& scenario) {
  const Team& team = scenario.team;
  SensedTeam sensed;
  const std::vector<double> none(size(team.nu()) + 1, 0.0);
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    sensed.robots.push_back({.name = std::string(team.name(body)), .position = true, .heading = true});
    const Sight<double> sight =
        team.model(body).sight(scenario.x0.data() + team.state_offset(body), none.data());
    sensed.places.push_back({sight.p.x, sight.p.y, sight.p.z, atan2(sight.d.y, sight.d.x)});
  }
  for (const LocalizedRobot& localized : scenario.localization.robots) {
    SensingRobot& robot = sensed.robots[at(localized.robot)];
    robot.position = false;
    robot.heading = localized.filter.compass_noise > 0;
    for (const BodyId target : localized.observes)
      sensed.sightings.push_back(
          {localized.robot.index, target.index, sees_headings(scenario, localized.robot)});
  }
  return sensed;
}

void read_estimates(const TomlTable& root, ScenarioSpec& scenario) {
  LocalizerOptions& options = scenario.localization;
  const TomlTable all = root.table_or_empty("estimate");
  const FilterOptions team_filter =
      read_part<FilterOptions>(TableSource(all), std::array<std::string_view, 2>{"cycles", "broadcast"});
  if (all.has("cycles") && all.word("cycles", cycle_words) == cycle_words[1])
    options.cycles = Cycles::intersected;
  // The broadcast of poses, and their extrapolation between two messages.
  const TomlTable broadcast = all.table_or_empty("broadcast");
  const TableSource from(broadcast);
  std::vector<std::string_view> keys = parameter_keys<BroadcastOptions>();
  std::erase(keys, "sighting_rate");
  scenario.radio = read_part<Radio>(from, keys);
  broadcast.checked([&] { scenario.radio.check(); });
  read_parameters(from, options.broadcast);

  std::optional<TomlTable> first;
  for (const auto& [name, agent] : root.named_tables("agent")) {
    const BodyId robot = scenario.team.find(name);
    FilterOptions filter = team_filter;
    bool states_correlation = all.has(correlation_key);
    if (agent.has("estimate")) {
      const TomlTable own = agent.table("estimate");
      states_correlation = states_correlation || own.has(correlation_key);
      own.expect_only(parameter_keys<FilterOptions>());
      read_parameters(TableSource(own), filter);
    }
    if (!agent.has("localization") || agent.word("localization", localization_kinds) == localization_kinds[0])
      continue;
    options.robots.push_back(read_localized(agent, robot, filter, scenario));
    if (!states_correlation)
      options.robots.back().filter.correlation_time =
          scenario.vision.camera_of(robot)->camera.correlation_time;
    if (!first) first = agent;
  }
  if (!first) return;
  first->checked([&] { (void)localization_graph(scenario.team, options); });
  refuse_unknown_headings(*first, scenario);
  // Searching requires a robot that can turn.
  first->checked([&] { validate(scenario.team, *guard_options(scenario)); });
}

const LocalizedRobot* localized_robot(const ScenarioSpec& scenario, BodyId body) {
  const auto& robots = scenario.localization.robots;
  const auto found =
      std::find_if(robots.begin(), robots.end(), [&](const LocalizedRobot& of) { return of.robot == body; });
  return found == robots.end() ? nullptr : &*found;
}

TelemetryOptions telemetry_options(const ScenarioSpec& scenario) {
  TelemetryOptions options{.seed = scenario.simulation.seed, .radio = scenario.radio};
  for (const LocalizedRobot& robot : scenario.localization.robots) {
    options.robots.push_back({robot.robot, robot.filter});
    for (const BodyId body : robot.observes) {
      const auto& reported = options.broadcasters;
      if (localized_robot(scenario, body) == nullptr &&
          std::find(reported.begin(), reported.end(), body) == reported.end())
        options.broadcasters.push_back(body);
    }
  }
  return options;
}

std::string localization_words(const ScenarioSpec& scenario) {
  const LocalizerOptions& options = scenario.localization;
  if (options.robots.empty()) return {};
  const LocalizationGraph graph = localization_graph(scenario.team, options);
  std::string text;
  for (const LocalizedRobot& robot : options.robots) {
    std::vector<std::string_view> names;
    bool chain = options.broadcast.correlation_time > 0;
    for (const BodyId body : robot.observes) {
      names.push_back(scenario.team.name(body));
      chain = chain || graph.tier(body.index) > 0;
    }
    const FilterKind kind = chain ? FilterKind::chain : robot.filter.filter;
    fmt::format_to(std::back_inserter(text),
                   "localized   {}: no position enters, by view of {}, filter \"{}\", hop {}\n",
                   scenario.team.name(robot.robot), fmt::join(names, ", "),
                   filter_kinds[static_cast<std::size_t>(kind)], graph.tier(robot.robot.index));
    if (robot.mount.sigmas > 0)
      fmt::format_to(std::back_inserter(text),
                     "view        {}: regions of view shrink by {} standard deviations of what it sees\n",
                     scenario.team.name(robot.robot), robot.mount.sigmas);
  }
  const Radio& radio = scenario.radio;
  for (const BodyId body : telemetry_options(scenario).broadcasters)
    fmt::format_to(std::back_inserter(text),
                   "broadcast   {}: its pose at {} Hz, {} m and {} rad, latency {} to {} s\n",
                   scenario.team.name(body), radio.rate, radio.position_sigma, radio.heading_sigma,
                   radio.latency[0], radio.latency[1]);
  return text;
}

}  // namespace sightline
