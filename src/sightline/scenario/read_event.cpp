#include "sightline/scenario/read_event.hpp"

#include <fmt/format.h>

#include "sightline/events.hpp"
#include "sightline/scenario/event_text.hpp"

namespace sightline {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// The couplings and constraints of the whole flight: the team's, and those that events add.
void enter_terms(const std::vector<TomlTable>& events, EventScope& scope) {
  const auto enter = [&](const std::string& name, const Potential& potential, BodyId observer, bool is_pair) {
    if (name.empty()) return;
    scope.terms.push_back({name, observer, is_pair});
    if (potential.mount() != nullptr) scope.terms.back().mount = *potential.mount();
  };
  scope.couplings = scope.team.couplings();
  for (const Constraint& c : scope.team.constraints()) enter(c.name, c.term.potential, c.agent, false);
  for (const TomlTable& event : events) {
    if (!event.has("add")) continue;
    const TomlValue value = event.value("add", "an action");
    for (const TomlValue& item : value.is_array() ? value.items() : std::vector{value}) {
      if (!item.is_table()) continue;
      const TomlTable at = item.table();
      if (at.has("couple")) scope.couplings.push_back(read_added_coupling(at.table("couple"), scope));
      if (at.has("constrain")) {
        const Constraint c = read_added_constraint(at.table("constrain"), scope);
        enter(c.name, c.term.potential, c.agent, false);
      }
    }
  }
  for (const Coupling& c : scope.couplings) enter(c.name, c.term.potential, c.between.first, true);
}

/// Its own name, or its place in the file.
std::string read_event_name(const TomlTable& at, const Script& before, std::size_t place) {
  if (!at.has("name")) return fmt::format("event[{}]", place);
  std::string name = read_label(at, "name");
  const auto same = [&](const TeamEvent& other) { return other.name == name; };
  if (std::any_of(before.events.begin(), before.events.end(), same)) {
    at.throw_invalid("name", "a name of its own, another event has this one");
  }
  return name;
}

TeamEvent read_event(const TomlTable& at, const EventScope& scope, const Script& before, std::size_t place) {
  TeamEvent event{.name = read_event_name(at, before, place),
                  .trigger = read_trigger(at, scope,
                                          {"name", "stage", "repeat", "enter", "ramp", "remove", "add",
                                           "retune", "reference", "observe", "move", "wind", "fault"})};
  if (at.has("stage")) event.stage = read_label(at, "stage");
  if (at.has("enter")) event.enter = read_label(at, "enter");
  if (at.has("repeat")) event.repeat = at.boolean("repeat");
  if (at.has("ramp")) event.ramp = at.number("ramp", time_range);
  event.actions = read_actions(at, scope);
  return event;
}

/// The bodies that a measure of [[event]] refers to.
std::vector<BodyId> bodies_of(const Measure& measure) {
  if (const auto* distance = std::get_if<DistanceOf>(&measure)) return {distance->a, distance->b};
  if (const auto* angle = std::get_if<ViewAngleOf>(&measure)) return {angle->observer, angle->target};
  if (const auto* age = std::get_if<AgeOf>(&measure)) return {age->body};
  if (const auto* excess = std::get_if<ExcessOf>(&measure)) return {excess->a, excess->b};
  return {};
}

/// Rejects events about bodies that are never present. `tables` belong to the script's last events.
void check_presence(const std::vector<TomlTable>& tables, const Script& script,
                    const ScenarioSpec& scenario) {
  std::vector<Presence> presence = scenario.presence;
  for (const TeamEvent& event : script.events) {
    for (const Action& action : event.actions) {
      const auto* add = std::get_if<AddBody>(&action);
      if (add != nullptr) presence[static_cast<std::size_t>(add->body.index)] = Presence::hold;
    }
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const auto check = [&](std::string_view key, BodyId body) {
      if (!tables[i].has(key) || presence[static_cast<std::size_t>(body.index)] != Presence::absent) return;
      tables[i].throw_invalid(key, fmt::format("bodies that are there, \"{}\" is not and no event adds it",
                                               scenario.team.name(body)));
    };
    const TeamEvent& event = script.events[script.events.size() - tables.size() + i];
    if (const auto* condition = std::get_if<Condition>(&event.trigger)) {
      for (const BodyId body : bodies_of(condition->measure)) {
        for (const std::string_view key : {"when", "lost", "seen"}) check(key, body);
      }
    }
    for (const Action& action : event.actions) {
      if (const auto* observe = std::get_if<Observe>(&action)) check("observe", observe->target);
    }
  }
}

}  // namespace

std::vector<TimedSignal> read_signals(const TomlTable& simulation) {
  std::vector<TimedSignal> signals;
  for (const TomlTable& at : simulation.tables("signal")) {
    at.expect_only({"at", "name"});
    TimedSignal& signal = signals.emplace_back();
    signal.name = read_label(at, "name");
    signal.at = at.has("at") ? at.number("at", time_range) : never;
  }
  std::stable_sort(signals.begin(), signals.end(),
                   [](const TimedSignal& a, const TimedSignal& b) { return a.at < b.at; });
  return signals;
}

Script read_events(const TomlTable& root, const ScenarioSpec& scenario, const Observers& observers) {
  const auto& presence = scenario.presence;
  if (std::find(presence.begin(), presence.end(), Presence::steered) == presence.end()) {
    root.throw_invalid("agent", "at least one robot that is present at the start");
  }
  EventScope scope{scenario.team, observers, scenario.simulation};
  const std::vector<TomlTable> tables = root.tables("event");
  enter_terms(tables, scope);
  Script script = scenario.script;  // events of shapes
  const std::size_t of_shapes = script.events.size();
  for (const TomlTable& at : tables) {
    script.events.push_back(read_event(at, scope, script, script.events.size() - of_shapes));
  }
  check_presence(tables, script, scenario);
  const std::vector<ScriptFault> faults = faults_of(script, ActiveTeam(scenario.team, presence));
  if (faults.empty()) return script;
  const auto [event, sentence] = faults.front();
  if (event < of_shapes) root.throw_invalid("shape", sentence);
  tables[event - of_shapes].rethrow_at(sentence);
  return script;
}

}  // namespace sightline
