#include "sightline/scenario/read_shape.hpp"

#include <fmt/format.h>

#include "sightline/events.hpp"
#include "sightline/world/view_flight.hpp"

namespace sightline {
namespace {

constexpr std::string_view observer_word = "observer", both_word = "both", all_word = "all";

/// The bodies of a shape, each named once.
std::vector<BodyId> read_members(const TomlTable& at, std::string_view key, std::size_t least,
                                 const Team& team) {
  std::vector<BodyId> bodies = bodies_named(at, key, TomlTable::any_length, team);
  for (auto body = bodies.begin(); body != bodies.end(); ++body) {
    if (std::find(bodies.begin(), body, *body) == body) continue;
    at.throw_invalid(key, static_cast<std::size_t>(body - bodies.begin()), "each body once");
  }
  if (bodies.size() < least) at.throw_invalid(key, fmt::format("an array of {} names or more", least));
  return bodies;
}

std::vector<Between> read_chain(const TomlTable& at, const Team& team) {
  return chain(read_members(at, "chain", 2, team));
}

std::vector<Between> read_ring(const TomlTable& at, const Team& team) {
  return ring(read_members(at, "ring", 2, team));
}

std::vector<Between> read_star(const TomlTable& shape, const Team& team) {
  const TomlTable at = shape.table("star", "a table with centre and observers");
  at.expect_only({"centre", "observers"});
  const BodyId centre =
      team.find(read_name(at, "centre", team, Among::bodies, "a robot, target or obstacle"));
  const std::vector<BodyId> observers = read_members(at, "observers", 1, team);
  const auto found = std::find(observers.begin(), observers.end(), centre);
  if (found != observers.end()) {
    at.throw_invalid("observers", static_cast<std::size_t>(found - observers.begin()),
                     "another body than centre");
  }
  return star(centre, observers);
}

std::vector<Between> read_all_pairs(const TomlTable& at, const Team& team) {
  constexpr std::string_view key = "all_pairs", expected = "an array of names, or \"all\" for all robots";
  const TomlValue value = at.value(key, expected);
  if (!value.is_text()) {
    if (!value.is_array()) value.throw_invalid(expected);
    return all_pairs(read_members(at, key, 2, team));
  }
  if (value.text() != all_word) value.throw_invalid(expected);
  std::vector<BodyId> robots;
  for (int i = 0; i < team.bodies(); ++i) {
    if (team.is_agent(BodyId{i})) robots.push_back(BodyId{i});
  }
  if (robots.size() < 2) value.throw_invalid("an array of names, the team has a single robot");
  return all_pairs(robots);
}

using ReadPairs = std::vector<Between> (*)(const TomlTable& shape, const Team& team);
constexpr std::array shapes = {
    Named<ReadPairs>{"chain", read_chain},
    Named<ReadPairs>{"star", read_star},
    Named<ReadPairs>{"ring", read_ring},
    Named<ReadPairs>{"all_pairs", read_all_pairs},
};

/// Reads on which robots a shape acts; `observer` requires that every observer is a robot.
FeltBy read_felt_by(const TomlTable& at, const std::vector<Between>& pairs, const Team& team) {
  constexpr std::array words = {observer_word, both_word};
  if (!at.has("felt_by") || at.word("felt_by", words) == both_word) return FeltBy::both;
  for (const Between& pair : pairs) {
    if (team.is_agent(pair.first)) continue;
    at.throw_invalid("felt_by", fmt::format("robots as observers, \"{}\" is none", team.name(pair.first)));
  }
  return FeltBy::observer;
}

/// A name that no other shape uses for its stages or its choice.
std::string read_shape_name(const TomlTable& shape, std::string_view missing, const Script& script) {
  std::string name = shape.has("name") ? read_label(shape, "name") : std::string(missing);
  const bool taken = std::any_of(script.begins.begin(), script.begins.end(),
                                 [&](const std::string& stage) { return region_of(stage) == name; }) ||
                     std::any_of(script.choices.begin(), script.choices.end(),
                                 [&](const ViewChoice& choice) { return choice.name == name; });
  if (taken) shape.throw_invalid("name", "a name of its own, another shape has this one");
  return name;
}

/// `nearest = { target, observers, margin, dwell, ramp }`, and `name`: the nearest robot observes.
void read_relay(const TomlTable& shape, const TermsOf& terms_of, Team& team, Script& script) {
  const TomlTable at = shape.table("nearest", "a table with target and observers");
  RelayOptions options{.name = read_shape_name(shape, "nearest", script)};
  at.read({{"margin", &options.margin, not_negative(">= 0 m")},
           {"dwell", &options.dwell, positive("> 0 s")},
           {"ramp", &options.ramp, time_range}},
          {"target", "observers"});
  const BodyId target =
      team.find(read_name(at, "target", team, Among::bodies, "a robot, target or obstacle"));
  std::vector<AgentId> observers;
  for (const BodyId body : read_members(at, "observers", 2, team)) {
    if (!team.is_agent(body) || body == target) {
      at.throw_invalid("observers", observers.size(), "a robot other than the target");
    }
    observers.push_back(AgentId{body});
  }
  shape.checked([&] { relay(team, script, terms_of, observers, target, options); });
}

/// Variance of each observer's view of each target, from its camera and the target's tags; equal
/// pairs are simulated once.
std::vector<ViewVariance> variances_of(const ViewChoice& choice, const CameraOptions& vision) {
  struct Flown {
    const RobotCamera* camera;
    const Tags* tags;
    ViewVariance variance;
  };
  std::vector<Flown> flown;
  std::vector<ViewVariance> all;
  for (const AgentId observer : choice.observers) {
    const RobotCamera* const camera = vision.camera_of(observer);
    for (const BodyId target : choice.targets) {
      const BodyTags* const tags = vision.tags_of(target);
      const auto same = std::find_if(flown.begin(), flown.end(), [&](const Flown& one) {
        return one.camera->camera == camera->camera && one.camera->mount == camera->mount &&
               *one.tags == tags->tags;
      });
      if (same != flown.end()) {
        all.push_back(same->variance);
        continue;
      }
      all.push_back(view_variance({.camera = camera->camera,
                                   .mount = camera->mount,
                                   .tags = tags->tags,
                                   .filter = {.correlation_time = camera->camera.correlation_time},
                                   .duration = 10.0}));
      flown.push_back({camera, &tags->tags, all.back()});
    }
  }
  return all;
}

/// `best = { target, observers, observers_max, margin, dwell, ramp }`, and `name`: each observer
/// views the target that gives its position the least variance.
void read_best(const TomlTable& shape, const TermsOf& terms_of, ScenarioSpec& scenario) {
  constexpr std::string_view target_key = "target", observers_key = "observers", max_key = "observers_max";
  const Team& team = scenario.team;
  const TomlTable at = shape.table("best", "a table with target and observers");
  ViewChoice choice{.name = read_shape_name(shape, "best", scenario.script)};
  double ramp = RelayOptions{}.ramp;
  at.read({{"margin", &choice.margin, not_negative(">= 0 m")},
           {"dwell", &choice.dwell, positive("> 0 s")},
           {"ramp", &ramp, time_range}},
          {target_key, observers_key, max_key});
  const TomlValue target = at.value(target_key, "the name of a body, or an array of names");
  const bool is_one = target.is_text();
  if (is_one) {
    choice.targets = {
        team.find(read_name(at, target_key, team, Among::bodies, "a robot, target or obstacle"))};
  } else {
    choice.targets = read_members(at, target_key, 1, team);
  }
  for (const BodyId body : read_members(at, observers_key, 1, team)) {
    const auto refuse_observer = [&](std::string_view expected) {
      at.throw_invalid(observers_key, choice.observers.size(), expected);
    };
    if (!team.is_agent(body) || (is_one && body == choice.targets[0]))
      refuse_observer(is_one ? "a robot other than the target" : "a robot");
    if (scenario.vision.camera_of(body) == nullptr)
      refuse_observer(fmt::format("a robot with a camera, [agent.{}.camera]", team.name(body)));
    choice.observers.push_back(AgentId{body});
  }
  for (std::size_t j = 0; j < choice.targets.size(); ++j) {
    if (scenario.vision.tags_of(choice.targets[j]) != nullptr) continue;
    const auto& targets = scenario.targets;
    const bool is_target = std::find(targets.begin(), targets.end(), choice.targets[j]) != targets.end();
    const std::string expected =
        fmt::format("a body with tags, [{}.{}.tags]",
                    team.is_agent(choice.targets[j]) ? "agent" : (is_target ? "target" : "obstacle"),
                    team.name(choice.targets[j]));
    if (is_one) at.throw_invalid(target_key, expected);
    at.throw_invalid(target_key, j, expected);
  }
  const auto is_observer = [&](BodyId body) {
    return std::find(choice.observers.begin(), choice.observers.end(), body) != choice.observers.end();
  };
  if (std::all_of(choice.targets.begin(), choice.targets.end(), is_observer))
    at.throw_invalid(
        target_key, "a body that is no observer among them, since one has to know its place without looking");
  if (is_one) choice.at_most = 1;
  if (at.has(max_key)) choice.at_most = static_cast<int>(at.integer(max_key, 1, agents_max));
  if (choice.observers.size() * choice.targets.size() > shape_couplings_max)
    at.throw_invalid(observers_key,
                     fmt::format("at most {} pairs of observer and target", shape_couplings_max));

  for (const AgentId observer : choice.observers) {
    const SensorMount& of_camera = scenario.vision.camera_of(observer)->mount;
    const BodyId other =
        choice.targets[BodyId(observer) == choice.targets[0] ? choice.targets.size() - 1 : 0];
    for (const Weighted& term : terms_of({observer, other}))
      if (term.potential.mount() != nullptr && *term.potential.mount() != of_camera)
        at.throw_invalid(observers_key,
                         fmt::format("robots with a camera at their sensor, {} has [agent.{}.sensors]",
                                     team.name(observer), team.name(observer)));
  }
  choice.variances = variances_of(choice, scenario.vision);
  const std::vector<double> u = resting_inputs(team);
  choice.first = ViewChooser::first(
      choice, team, {.t = 0.0, .x = scenario.x0, .u = u, .ages = {}, .presence = scenario.presence});
  shape.checked([&] { best(scenario.team, scenario.script, terms_of, std::move(choice), ramp); });
}

}  // namespace

void read_shape(const TomlTable& at, const Observers& observers, ScenarioSpec& scenario) {
  constexpr std::string_view nearest_word = "nearest", best_word = "best", sensor_word = "sensor";
  Team& team = scenario.team;
  const bool is_best = at.has(best_word), is_relay = at.has(nearest_word);
  if (is_best && is_relay) at.throw_invalid(best_word, "no such key beside nearest");
  std::vector<Between> pairs;
  FeltBy felt_by = FeltBy::observer;
  std::string_view name = nearest_word;
  if (is_best || is_relay) {
    name = is_best ? best_word : nearest_word;
    at.expect_only({"name", name, "potential", "weight", "potentials", "sensor"});
  } else {
    name = at.choice(names(shapes), {"potential", "weight", "potentials", "felt_by", "sensor"});
    pairs = find(shapes, name)(at, team);
    felt_by = read_felt_by(at, pairs, team);
  }

  // One potential as in [[couple]], or a list of potentials with weights.
  std::vector<TomlTable> list;
  if (at.has("potentials")) {
    for (const std::string_view key : {"potential", "weight"}) {
      if (at.has(key)) at.throw_invalid(key, "no such key beside potentials, which have their own");
    }
    list = at.tables("potentials");
    if (list.empty()) at.throw_invalid("potentials", "one potential or more");
  } else if (!at.has("potential")) {
    at.throw_invalid("potentials", "an array of potentials, or potential and weight");
  }
  if (pairs.size() * std::max<std::size_t>(list.size(), 1) > shape_couplings_max) {
    at.throw_invalid(name, fmt::format("at most {} couplings", shape_couplings_max));
  }
  const TermsOf terms_of = [&](Between pair) {
    const Observer observer = read_looking(at, observer_of(team, observers, pair.first));
    std::vector<Weighted> terms;
    if (list.empty()) terms.push_back(read_potential(at, observer));
    for (const TomlTable& entry : list) terms.push_back(read_weighted(entry, observer));
    const auto looks = [](const Weighted& term) { return term.potential.mount() != nullptr; };
    if (at.has(sensor_word) && std::none_of(terms.begin(), terms.end(), looks))
      at.throw_invalid(sensor_word, "no such key: no potential of the shape looks through a sensor");
    return terms;
  };
  if (is_best && at.has(sensor_word))
    at.throw_invalid(sensor_word, "no such key beside best, whose observers look through their cameras");
  if (is_relay) return read_relay(at, terms_of, team, scenario.script);
  if (is_best) return read_best(at, terms_of, scenario);
  at.checked([&] { couple(team, terms_of, pairs, felt_by); });
}

}  // namespace sightline
