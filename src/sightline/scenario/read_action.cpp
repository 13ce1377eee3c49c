#include "sightline/scenario/read_action.hpp"

#include <fmt/format.h>

namespace sightline {
namespace {

AgentId agent_named(const TomlTable& at, std::string_view key, const Team& team) {
  return AgentId{team.find(read_name(at, key, team, Among::robots, "a robot"))};
}

/// The body under `agent`, `target` or `obstacle`, of that kind.
BodyId body_of_kind(const TomlTable& at, std::string_view kind, const Team& team) {
  if (kind == "agent") return agent_named(at, kind, team);
  std::vector<std::string_view> known = body_names(team, Among::bodies);
  std::erase_if(known, [&](std::string_view name) { return team.is_agent(team.find(name)); });
  return team.find(at.value(kind, "a name").word(known, "a target or obstacle"));
}

/// The name of a coupling or of a constraint, by the key `couple` or `constrain`.
const NamedTerm& term_named(const TomlTable& at, std::string_view key, const EventScope& scope) {
  const bool is_pair = key == "couple";
  std::vector<std::string_view> known;
  for (const NamedTerm& term : scope.terms) {
    if (term.is_pair == is_pair) known.push_back(term.name);
  }
  const std::string_view name =
      at.value(key, "a name")
          .word(known, is_pair ? "the name of a [[couple]]" : "the name of a [[constrain]]");
  return *std::find_if(scope.terms.begin(), scope.terms.end(),
                       [&](const NamedTerm& term) { return term.is_pair == is_pair && term.name == name; });
}

constexpr std::array<std::string_view, 5> things = {"agent", "target", "obstacle", "couple", "constrain"};

Action read_remove(const TomlValue& value, const EventScope& scope) {
  if (value.is_text()) return RemoveBody{read_body(value, scope.team)};
  if (!value.is_table()) value.refuse("the name of a body, or a table");
  const TomlTable at = value.table();
  const std::string_view kind = at.choice(things, {"then"});
  if (kind != "agent" && at.has("then")) at.refuse("then", "no such key but beside agent");
  if (kind == "couple" || kind == "constrain") return RemoveTerm{term_named(at, kind, scope).name};
  RemoveBody remove{body_of_kind(at, kind, scope.team)};
  constexpr std::array<std::string_view, 3> words = {"vanish", "hold", "land"};  // in the order of Afterwards
  if (at.has("then")) {
    const auto word = std::find(words.begin(), words.end(), at.word("then", words)) - words.begin();
    remove.afterwards = static_cast<Afterwards>(word);
  }
  return remove;
}

Action read_add(const TomlValue& value, const EventScope& scope) {
  if (value.is_text()) return AddBody{read_body(value, scope.team)};
  if (!value.is_table()) value.refuse("the name of a body, or a table");
  const TomlTable at = value.table();
  const std::string_view kind = at.choice(things);
  if (kind == "couple") return AddCoupling{read_added_coupling(at.table(kind), scope)};
  if (kind == "constrain") return AddConstraint{read_added_constraint(at.table(kind), scope)};
  return AddBody{body_of_kind(at, kind, scope.team)};
}

Action retune_term(const TomlTable& at, std::string_view kind, const EventScope& scope) {
  at.expect_only({kind, "weight", "potential"});
  const NamedTerm& term = term_named(at, kind, scope);
  RetuneTerm retune{.name = term.name};
  if (at.has("weight")) retune.weight = at.number("weight", not_negative(">= 0"));
  if (at.has("potential")) {
    retune.potential = read_potential(at, observer_of(scope.team, scope.observers, term.observer)).potential;
    if (retune.potential->is_pair() != term.is_pair) {
      at.refuse("potential",
                term.is_pair ? "a potential between two bodies" : "a potential of one robot alone");
    }
  }
  if (at.size() == 1) at.refuse("weight", "weight or potential, whatever changes");
  return retune;
}

Action retune_agent(const TomlTable& at, const Team& team) {
  at.expect_only({"agent", "Q", "R", "Q_f", "u_ref", "u_min", "u_max"});
  const AgentId id = agent_named(at, "agent", team);
  Agent agent = team.agent(id);
  RetuneAgent retune{.agent = id};
  const auto read = [&](std::string_view key, std::vector<double>& to, const Range& range) {
    if (!at.has(key)) return std::optional<std::vector<double>>();
    to = at.numbers(key, to.size(), range);
    return std::optional(to);
  };
  retune.Q = read("Q", agent.Q, not_negative(">= 0"));
  retune.R = read("R", agent.R, positive("> 0"));
  retune.Q_f = read("Q_f", agent.Q_f, not_negative(">= 0"));
  retune.u_ref = read("u_ref", agent.u_ref, any_number());
  if (at.has("u_min") || at.has("u_max")) {
    const InputLimits& limits = agent.limits;
    for (const std::string_view key : {"u_min", "u_max"}) {
      if (!at.has(key) && limits.times().size() > 1) {
        at.refuse(key, "both u_min and u_max, the limits of this robot change over time");
      }
    }
    std::vector<double> u_min = limits.u_min().front(), u_max = limits.u_max().front();
    read("u_min", u_min, any_number());
    read("u_max", u_max, any_number());
    retune.limits = at.checked([&] { return InputLimits(u_min, u_max); });
  }
  if (at.size() == 1) at.refuse("one of Q, R, Q_f, u_ref, u_min, u_max beside agent");
  return retune;
}

Action read_retune(const TomlValue& value, const EventScope& scope) {
  if (!value.is_table()) value.refuse("a table");
  const TomlTable at = value.table();
  constexpr std::array<std::string_view, 3> kinds = {"agent", "couple", "constrain"};
  const std::string_view kind =
      at.choice(kinds, {"weight", "potential", "Q", "R", "Q_f", "u_ref", "u_min", "u_max"});
  return kind == "agent" ? retune_agent(at, scope.team) : retune_term(at, kind, scope);
}

Action read_new_reference(const TomlValue& value, const EventScope& scope) {
  if (!value.is_table()) value.refuse("a table with agent and reference");
  const TomlTable at = value.table();
  at.expect_only({"agent", "reference"});
  const AgentId agent = agent_named(at, "agent", scope.team);
  if (!at.has("reference")) at.refuse("reference", "a reference as in [agent.NAME]");
  return SetReference{agent, read_reference(at, scope.team.model(agent))};
}

Action read_observe(const TomlValue& value, const EventScope& scope) {
  if (!value.is_table()) value.refuse("a table with observer and target");
  const TomlTable at = value.table();
  at.expect_only({"observer", "target"});
  const Observe observe{agent_named(at, "observer", scope.team),
                        read_body(at.value("target", "the name of a body"), scope.team)};
  if (observe.observer == observe.target) at.refuse("target", "another body than observer");
  if (!observer_of(scope.team, scope.observers, observe.observer).mount) {
    at.refuse("observer", "a robot with a sensor");
  }
  return observe;
}

using ReadAction = Action (*)(const TomlValue& value, const EventScope& scope);
constexpr std::array actions = {
    Named<ReadAction>{"remove", read_remove},           Named<ReadAction>{"add", read_add},
    Named<ReadAction>{"retune", read_retune},           Named<ReadAction>{"observe", read_observe},
    Named<ReadAction>{"reference", read_new_reference},
};

}  // namespace

Coupling read_added_coupling(const TomlTable& couple, const EventScope& scope) {
  Coupling coupling = read_coupling(couple, scope.team, scope.observers);
  Team trial = scope.team;
  couple.checked([&] { trial.couple(coupling.term, coupling.between, coupling.felt_by); });
  return coupling;
}

Constraint read_added_constraint(const TomlTable& constrain, const EventScope& scope) {
  constrain.expect_only({"name", "agent", "potential", "weight"});
  const AgentId agent = agent_named(constrain, "agent", scope.team);
  Constraint constraint{.term = read_potential(constrain, observer_of(scope.team, scope.observers, agent)),
                        .agent = agent,
                        .name = read_term_name(constrain)};
  Team trial = scope.team;
  constrain.checked([&] { trial.constrain(constraint.term, agent); });
  return constraint;
}

bool is_action(std::string_view key) {
  const auto known = names(actions);
  return std::find(known.begin(), known.end(), key) != known.end();
}

std::vector<Action> read_actions(const TomlTable& event, std::string_view key, const EventScope& scope) {
  const auto read = find(actions, key);
  const TomlValue value = event.value(key, "an action");
  if (!value.is_array()) return {read(value, scope)};
  std::vector<Action> list;
  for (const TomlValue& item : value.items()) list.push_back(read(item, scope));
  if (list.empty()) value.refuse("one or more");
  return list;
}

}  // namespace sightline
