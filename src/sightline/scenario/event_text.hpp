/// When an event of a scenario happens, and what it does: the one trigger and the actions of [[event]].
#pragma once

#include "sightline/ocp/event.hpp"
#include "sightline/scenario/read_coupling.hpp"

namespace sightline {

/// A coupling or constraint that events may speak of, by its name.
struct NamedTerm {
  std::string name;
  BodyId observer;  ///< the first of a coupling, or the robot that is constrained
  bool is_pair = true;
};

/// What the events of a scenario may speak of.
struct EventScope {
  const Team& team;  ///< every body there will ever be
  const Observers& observers;
  const Simulation& simulation;
  std::vector<Coupling> couplings{};  ///< all there may ever be, of events too
  std::vector<NamedTerm> terms{};     ///< likewise
};

/// A table of an event as a trigger or an action reads it (ocp/event/). Every function throws ScenarioError.
class EventText : public TomlTable {
 public:
  EventText(const TomlTable& at, const EventScope& scope) : TomlTable(at), scope_(&scope) {}

  /// A table within this one.
  EventText table(std::string_view key, std::string_view expected) const {
    return {TomlTable::table(key, expected), *scope_};
  }

  AgentId robot(std::string_view key) const;
  BodyId body(std::string_view key, std::string_view expected) const;
  /// The body under `agent`, `target` or `obstacle`, of that kind.
  BodyId body_of_kind(std::string_view kind) const;
  /// The two different bodies in the array under `key`.
  Between two_bodies(std::string_view key) const;
  /// A robot, for what is between two bodies, both of them.
  Between one_robot(std::string_view key) const;
  /// The term that there may be, by its name under `couple` or `constrain`.
  const NamedTerm& term(std::string_view kind) const;

  /// A term that the event adds, of the table under `key`.
  Coupling coupling(std::string_view key) const;
  Constraint constraint(std::string_view key) const;
  /// The one of this table.
  Potential potential(BodyId observer) const;
  Reference reference(AgentId agent) const;
  /// Of `region` or `formula`, as `first` sees it, which the table names under `named_by`.
  Potential limits(std::string_view key, BodyId first, std::string_view named_by) const;

  bool has_sensor(BodyId body) const;
  /// Refuses the `key` that names a body without a sensor.
  const SensorMount& sensor_of(BodyId body, std::string_view key) const;
  /// Of the coupling by which one looks at the other, if it states a limit.
  const Potential* limit_of_view(BodyId observer, BodyId target) const;
  const Agent& agent(AgentId id) const { return scope_->team.agent(id); }
  std::string_view name(BodyId body) const { return scope_->team.name(body); }
  /// Those that are sent in the simulation.
  std::vector<std::string_view> signals() const;
  /// Of the simulation [s].
  double duration() const { return scope_->simulation.duration; }

 private:
  const EventScope* scope_;
};

/// A coupling as an event adds it, `add = { couple = {...} }`, and a constraint likewise.
Coupling read_added_coupling(const TomlTable& couple, const EventScope& scope);
Constraint read_added_constraint(const TomlTable& constrain, const EventScope& scope);

/// The body of that name in a text.
BodyId read_body(const TomlValue& value, const Team& team);

/// The trigger of an event, which has exactly one.
/// @param others  keys that may stand beside it
Trigger read_trigger(const TomlTable& event, const EventScope& scope,
                     std::initializer_list<std::string_view> others);

/// Whether the key of an event says an action.
bool is_action(std::string_view key);

/// The actions under one such key: one, or an array of them.
std::vector<Action> read_actions(const TomlTable& event, std::string_view key, const EventScope& scope);

}  // namespace sightline
