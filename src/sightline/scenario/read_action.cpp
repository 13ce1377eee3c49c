#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sightline/scenario/event_text.hpp"
#include "sightline/scenario/read_event.hpp"

namespace sightline {
namespace {

/// The place of a word in a list that has it.
template <class Enum, std::size_t n>
Enum value_of(std::string_view word, const std::array<std::string_view, n>& words) {
  return static_cast<Enum>(std::find(words.begin(), words.end(), word) - words.begin());
}

bool is_term(std::string_view kind) { return kind == "couple" || kind == "constrain"; }

Action read_remove(const EventText& remove, std::string_view kind) {
  if (kind != "agent" && remove.has("then")) remove.throw_invalid("then", "no such key but beside agent");
  if (is_term(kind)) return RemoveTerm{remove.term(kind).name};
  RemoveBody read{remove.body_of_kind(kind)};
  constexpr std::array<std::string_view, 3> words = {"vanish", "hold", "land"};  // in the order of Afterwards
  if (remove.has("then")) read.afterwards = value_of<Afterwards>(remove.word("then", words), words);
  return read;
}

Action read_add(const EventText& add, std::string_view kind) {
  if (kind == "couple") return AddCoupling{add.coupling(kind)};
  if (kind == "constrain") return AddConstraint{add.constraint(kind)};
  return AddBody{add.body_of_kind(kind)};
}

Action read_retune_agent(const EventText& retune) {
  retune.expect_only({"agent", "Q", "R", "Q_f", "u_ref", "u_min", "u_max"});
  RetuneAgent read{.agent = retune.robot("agent")};
  const Agent& now = retune.agent(read.agent);
  const auto numbers = [&](std::string_view of, std::size_t length, const Range& range) {
    return retune.has(of) ? std::optional(retune.numbers(of, length, range)) : std::nullopt;
  };
  read.Q = numbers("Q", now.Q.size(), not_negative(">= 0"));
  read.R = numbers("R", now.R.size(), positive("> 0"));
  read.Q_f = numbers("Q_f", now.Q_f.size(), not_negative(">= 0"));
  read.u_ref = numbers("u_ref", now.u_ref.size(), any_number());
  if (retune.has("u_min") || retune.has("u_max")) {
    for (const std::string_view of : {"u_min", "u_max"}) {
      if (!retune.has(of) && now.limits.times().size() > 1) {
        retune.throw_invalid(of, "both u_min and u_max, the limits of this robot change over time");
      }
    }
    const auto& u_min = now.limits.u_min().front();
    const auto& u_max = now.limits.u_max().front();
    const auto low = numbers("u_min", u_min.size(), any_number()).value_or(u_min);
    const auto high = numbers("u_max", u_max.size(), any_number()).value_or(u_max);
    read.limits = retune.checked([&] { return InputLimits(low, high); });
  }
  if (retune.size() == 1) retune.throw_invalid("one of Q, R, Q_f, u_ref, u_min, u_max beside agent");
  return read;
}

Action read_retune(const EventText& retune, std::string_view kind) {
  if (!is_term(kind)) return read_retune_agent(retune);
  retune.expect_only({kind, "weight", "potential"});
  const NamedTerm& term = retune.term(kind);
  RetuneTerm read{.name = term.name};
  if (retune.has("weight")) read.weight = retune.number("weight", not_negative(">= 0"));
  if (retune.has("potential")) {
    read.potential = retune.potential(term);
    if (read.potential->is_pair() != term.is_pair) {
      retune.throw_invalid(
          "potential", term.is_pair ? "a potential between two bodies" : "a potential of one robot alone");
    }
  }
  if (retune.size() == 1) retune.throw_invalid("weight", "weight or potential, whatever changes");
  return read;
}

Action read_observe(const EventText& observe, std::string_view /*kind*/) {
  observe.expect_only({"observer", "target", "sensor"});
  Observe read{observe.robot("observer"), observe.body("target", "the name of a body")};
  if (read.observer == read.target) observe.throw_invalid("target", "another body than observer");
  const Observer observer = observe.observer("observer");
  if (!observer.mount)
    observe.throw_invalid(
        "sensor",
        fmt::format("a sensor of [agent.{0}.sensors], there is no [agent.{0}.sensor]", observer.name));
  if (!observer.sensors.empty()) read.through = observer.mount;
  return read;
}

Action read_set_reference(const EventText& change, std::string_view /*kind*/) {
  change.expect_only({"agent", "reference"});
  const AgentId agent = change.robot("agent");
  if (!change.has("reference")) change.throw_invalid("reference", "a reference as in [agent.NAME]");
  return SetReference{agent, change.reference(agent)};
}

Action read_move(const EventText& move, std::string_view kind) {
  move.expect_only({kind, "p"});
  return MoveBody{move.body_of_kind(kind), move.vec3("p")};
}

Action read_set_wind(const EventText& wind, std::string_view /*kind*/) {
  wind.expect_only({"acceleration"});
  return SetWind{wind.vec3("acceleration")};
}

Action read_fault(const EventText& fault, std::string_view /*kind*/) {
  fault.expect_only({"kind", "body", "for", "offset"});
  InjectFault read{.kind = value_of<Surroundings::FaultKind>(fault.word("kind", fault_words), fault_words),
                   .body = fault.body("body", "the name of a body"),
                   .lasts = fault.number("for", positive("> 0 s"))};
  if (read.kind == Surroundings::FaultKind::jump) {
    read.offset = fault.vec3("offset");
  } else if (fault.has("offset")) {
    fault.throw_invalid("offset", "no such key beside another kind than jump");
  }
  return read;
}

/// A key of an event that names actions.
struct ActionKey {
  std::string_view key, expected;  ///< in the error for a value that is not a table
  Action (*read)(const EventText& text, std::string_view kind);
  std::vector<std::string_view> kinds{}, beside{};  ///< exactly one of `kinds` is in its table
  Action (*named)(BodyId body) = nullptr;           ///< made of a body alone: remove = "uav2"
};

const std::vector<ActionKey>& action_keys() {
  static const std::vector<ActionKey> keys = {
      {"remove",
       "the name of a body, or a table",
       read_remove,
       {"agent", "target", "obstacle", "couple", "constrain"},
       {"then"},
       [](BodyId body) -> Action { return RemoveBody{body}; }},
      {"add",
       "the name of a body, or a table",
       read_add,
       {"agent", "target", "obstacle", "couple", "constrain"},
       {},
       [](BodyId body) -> Action { return AddBody{body}; }},
      {"retune",
       "a table",
       read_retune,
       {"agent", "couple", "constrain"},
       {"Q", "R", "Q_f", "u_ref", "u_min", "u_max", "weight", "potential"}},
      {"observe", "a table with observer and target", read_observe},
      {"reference", "a table with agent and reference", read_set_reference},
      {"move", "a table", read_move, {"target", "obstacle"}, {"p"}},
      {"wind", "a table with acceleration", read_set_wind},
      {"fault", "a table with kind, body and for", read_fault}};
  return keys;
}

Action read_action(const TomlValue& value, const ActionKey& of, const EventScope& scope) {
  if (of.named != nullptr && value.is_text()) return of.named(read_body(value, scope.team));
  if (!value.is_table()) value.throw_invalid(of.expected);
  const EventText text(value.table(), scope);
  return of.read(text, of.kinds.empty() ? std::string_view() : text.choice(of.kinds, of.beside));
}

}  // namespace

std::vector<Action> read_actions(const TomlTable& event, const EventScope& scope) {
  std::vector<Action> actions;
  for (const std::string& key : event.keys()) {
    const auto of = std::find_if(action_keys().begin(), action_keys().end(),
                                 [&](const ActionKey& one) { return one.key == key; });
    if (of == action_keys().end()) continue;
    const TomlValue value = event.value(key, "an action");
    const std::vector<TomlValue> items = value.is_array() ? value.items() : std::vector{value};
    for (const TomlValue& item : items) actions.push_back(read_action(item, *of, scope));
    if (items.empty()) value.throw_invalid("one or more");
  }
  return actions;
}

}  // namespace sightline
