/// Reads the trigger and the actions of an [[event]].
#pragma once

#include "sightline/events.hpp"
#include "sightline/scenario/read_coupling.hpp"

namespace sightline {

/// A coupling or constraint that events may refer to, by its name.
struct NamedTerm {
  std::string name;
  BodyId observer;  ///< the first of a coupling, or the constrained robot
  bool is_pair = true;
  std::optional<SensorMount> mount{};  ///< of the sensor that it looks through
};

/// What the events of a scenario may refer to.
struct EventScope {
  const Team& team;  ///< every body of the flight, present at the start or not
  const Observers& observers;
  const Simulation& simulation;
  std::vector<Coupling> couplings{};  ///< every coupling of the flight, of events too
  std::vector<NamedTerm> terms{};     ///< likewise
};

/// A table of an event, from which its trigger or an action is read. Every function throws
/// ScenarioError.
class EventText : public TomlTable {
 public:
  EventText(const TomlTable& at, const EventScope& scope) : TomlTable(at), scope_(&scope) {}

  /// A table within this one.
  EventText table(std::string_view key, std::string_view expected) const {
    return {TomlTable::table(key, expected), *scope_};
  }

  AgentId robot(std::string_view key) const;
  BodyId body(std::string_view key, std::string_view expected) const;
  /// The body under `kind`, one of `agent`, `target` and `obstacle`, of that kind.
  BodyId body_of_kind(std::string_view kind) const;
  /// The two different bodies in the array under `key`.
  Between two_bodies(std::string_view key) const;
  /// The robot under `key`, as both ends of a pair.
  Between one_robot(std::string_view key) const;
  /// The term that is named under `kind`, `couple` or `constrain`; it need not be in force.
  const NamedTerm& term(std::string_view kind) const;

  /// A term that the event adds, from the table under `key`.
  Coupling coupling(std::string_view key) const;
  Constraint constraint(std::string_view key) const;
  /// The potential of this table, for this term and its sensor.
  Potential potential(const NamedTerm& of) const;
  Reference reference(AgentId agent) const;
  /// The limits under `key`, `region` or `formula`, in the view of the first of `ends`. `named_by` is
  /// the key that names it.
  Potential limits(std::string_view key, Between ends, std::string_view named_by) const;

  /// The robot under `key` with its sensors, looking through that under `sensor`.
  /// @throws ScenarioError for a robot without a sensor
  Observer observer(std::string_view key) const;
  /// The mount of the sensor under `sensor`; without that key of the sensor by which the first views
  /// the second, else of the first's [agent.NAME.sensor].
  /// @throws ScenarioError for the `key` that names a first without a sensor
  SensorMount sensor_of(Between ends, std::string_view key) const;
  /// The potential of the coupling by which the first views the second, through the sensor under
  /// `sensor` if that key is there, and states a limit; else null.
  const Potential* limit_of_view(Between ends) const;
  const Agent& agent(AgentId id) const { return scope_->team.agent(id); }
  std::string_view name(BodyId body) const { return scope_->team.name(body); }
  /// Names of the signals that the simulation sends.
  std::vector<std::string_view> signals() const;
  /// Duration of the simulation [s].
  double duration() const { return scope_->simulation.duration; }

 private:
  const EventScope* scope_;
};

/// A coupling that an event adds, `add = { couple = {...} }`; below a constraint.
Coupling read_added_coupling(const TomlTable& couple, const EventScope& scope);
Constraint read_added_constraint(const TomlTable& constrain, const EventScope& scope);

/// The body that a text names.
BodyId read_body(const TomlValue& value, const Team& team);

/// The trigger of an event, which has exactly one.
/// @param others  keys that the table may have besides
Trigger read_trigger(const TomlTable& event, const EventScope& scope,
                     std::initializer_list<std::string_view> others);

/// The actions of an event, in the order of the file: one under a key, or an array of them.
std::vector<Action> read_actions(const TomlTable& event, const EventScope& scope);

}  // namespace sightline
