#include "sightline/scenario/read_coupling.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sightline/events.hpp"

namespace sightline {
namespace {

/// The robots named under `felt_by`, each once and one of `between`.
std::vector<AgentId> read_feeling(const TomlTable& at, Between between, const Team& team) {
  std::vector<AgentId> agents;
  for (const BodyId body : bodies_named(at, "felt_by", TomlTable::any_length, team)) {
    const AgentId agent{body};
    if (!team.is_agent(agent) || (agent != between.first && agent != between.second)) {
      at.throw_invalid("felt_by", agents.size(),
                       fmt::format("a robot of between = [\"{}\", \"{}\"]", team.name(between.first),
                                   team.name(between.second)));
    }
    if (std::find(agents.begin(), agents.end(), agent) != agents.end()) {
      at.throw_invalid("felt_by", agents.size(), "each robot once");
    }
    agents.push_back(agent);
  }
  return agents;
}

/// The third body, past which the potential looks: none of `between`; requires a potential with a
/// third body.
BodyId read_third(const TomlTable& at, const Coupling& coupling, const Team& team) {
  const BodyId third =
      team.find(at.value("third", "a name").word(body_names(team, Among::bodies), "the name of a body"));
  const auto& [first, second] = coupling.between;
  if (third == first || third == second) at.throw_invalid("third", "another body than those of between");
  if (!coupling.term.potential.sees_third())
    at.throw_invalid(
        "third",
        fmt::format("no such key: {} does not look past a third body, none of its formulas has third.p_x",
                    coupling.term.potential.name()));
  return third;
}

/// The robots of a [[keep_apart]].
std::vector<AgentId> read_agents(const TomlTable& at, const Team& team) {
  std::vector<AgentId> agents;
  const TomlValue value = at.value("agents", "\"all\" or a list of names");
  if (value.is_text()) {
    if (value.text() != "all") value.throw_invalid("\"all\" or a list of names");
    for (const Agent& agent : team.agents()) agents.push_back(AgentId{team.find(agent.name)});
    return agents;
  }
  const std::vector<std::string> names = at.texts("agents", TomlTable::any_length, "names");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const BodyId body = team.find(names[i]);
    if (body.index < 0 || !team.is_agent(body)) {
      std::vector<std::string_view> known;
      for (const Agent& agent : team.agents()) known.push_back(agent.name);
      at.throw_invalid("agents", i, "a robot" + hint(shortened(names[i], name_size_max), known));
    }
    if (std::find(agents.begin(), agents.end(), body) != agents.end())
      at.throw_invalid("agents", i, "each robot once");
    agents.push_back(AgentId{body});
  }
  return agents;
}

}  // namespace

Observer observer_of(const Team& team, const Observers& observers, BodyId body) {
  const auto i = static_cast<std::size_t>(body.index);  // agents come first
  return i < observers.size() ? observers[i] : Observer{std::string(team.name(body)), {}};
}

BodyId body_named(const TomlTable& at, std::string_view key, std::size_t i, std::string_view name,
                  const Team& team) {
  if (const BodyId body = team.find(name); body.index >= 0) return body;
  at.throw_invalid(key, i,
                   "a known name" + hint(shortened(name, name_size_max), body_names(team, Among::bodies)));
}

std::vector<BodyId> bodies_named(const TomlTable& at, std::string_view key, std::size_t length,
                                 const Team& team) {
  std::vector<BodyId> bodies;
  for (const std::string& name : at.texts(key, length, "names")) {
    bodies.push_back(body_named(at, key, bodies.size(), name, team));
  }
  return bodies;
}

std::string read_term_name(const TomlTable& at) {
  return at.has("name") ? read_label(at, "name") : std::string();
}

std::string name_or_place(const TomlTable& at) { return at.has("name") ? read_label(at, "name") : at.path(); }

Coupling read_coupling(const TomlTable& at, const Team& team, const Observers& observers) {
  at.expect_only({"name", "potential", "between", "felt_by", "weight", "third", "sensor"});
  const std::vector<BodyId> ends = bodies_named(at, "between", 2, team);
  const Between between = {ends[0], ends[1]};
  if (between.first == between.second) at.throw_invalid("between", "two different bodies");
  Coupling coupling{
      .term = read_potential(at, read_looking(at, observer_of(team, observers, between.first))),
      .between = between,
      .felt_by = at.has("felt_by") ? read_feeling(at, between, team) : feeling(team, between, FeltBy::both),
      .name = read_term_name(at)};
  if (at.has("sensor") && coupling.term.potential.mount() == nullptr)
    at.throw_invalid("sensor", fmt::format("no such key: {} does not look through a sensor",
                                           coupling.term.potential.name()));
  if (at.has("third")) coupling.third = read_third(at, coupling, team);
  return coupling;
}

void read_couple(const TomlTable& at, const Observers& observers, Team& team) {
  Coupling coupling = read_coupling(at, team, observers);
  coupling.name = name_or_place(at);
  at.checked([&] { team.couple(coupling); });
}

void read_keep_apart(const TomlTable& at, Team& team) {
  at.expect_only({"agents", "radius", "potential", "weight", "pairs_max"});
  const std::vector<AgentId> agents = read_agents(at, team);
  const double radius = at.has("radius") ? at.number("radius", positive("> 0 m")) : 2.5;
  const auto n = static_cast<std::int64_t>(agents.size());
  const std::int64_t all = std::max<std::int64_t>(1, n * (n - 1) / 2);
  // Far fewer robots touch at one time, but pairs that are near along the predictions count too.
  constexpr std::int64_t of_robot = 30, least = 2000;
  const std::int64_t room =
      at.has("pairs_max") ? at.integer("pairs_max", 1, 100'000) : std::max(least, of_robot * n);
  const Weighted term = read_potential(at, {std::string(team.agents()[0].name), {}});
  at.checked([&] { team.keep_apart(term, agents, radius, static_cast<int>(std::min(room, all))); });
}

}  // namespace sightline
