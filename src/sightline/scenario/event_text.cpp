#include "sightline/scenario/event_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sightline/ocp/apply_action.hpp"
#include "sightline/scenario/read_region.hpp"

namespace sightline {
namespace {

/// The first `wanted` potential by which the first of a pair observes the second; null if there is none.
template <class Wanted>
const Potential* first_view(const std::vector<Coupling>& couplings, Between pair, const Wanted& wanted) {
  for (const Coupling& c : couplings)
    if (is_view_of(c, pair) && wanted(c.term.potential)) return &c.term.potential;
  return nullptr;
}

}  // namespace
AgentId EventText::robot(std::string_view key) const {
  return AgentId{scope_->team.find(read_name(*this, key, scope_->team, Among::robots, "a robot"))};
}

BodyId EventText::body(std::string_view key, std::string_view expected) const {
  return read_body(value(key, expected), scope_->team);
}

BodyId EventText::body_of_kind(std::string_view kind) const {
  if (kind == "agent") return robot(kind);
  const Team& team = scope_->team;
  std::vector<std::string_view> known = body_names(team, Among::bodies);
  std::erase_if(known, [&](std::string_view name) { return team.is_agent(team.find(name)); });
  return team.find(value(kind, "a name").word(known, "a target or obstacle"));
}

Between EventText::two_bodies(std::string_view key) const {
  const std::vector<BodyId> ends = bodies_named(*this, key, 2, scope_->team);
  if (ends[0] == ends[1]) throw_invalid(key, "two different bodies");
  return {ends[0], ends[1]};
}

Between EventText::one_robot(std::string_view key) const {
  const BodyId one = robot(key);
  return {one, one};
}

const NamedTerm& EventText::term(std::string_view kind) const {
  const bool is_pair = kind == "couple";
  std::vector<std::string_view> known;
  for (const NamedTerm& term : scope_->terms) {
    if (term.is_pair == is_pair) known.push_back(term.name);
  }
  const std::string_view name =
      value(kind, "a name").word(known, is_pair ? "the name of a [[couple]]" : "the name of a [[constrain]]");
  return *std::find_if(scope_->terms.begin(), scope_->terms.end(),
                       [&](const NamedTerm& term) { return term.is_pair == is_pair && term.name == name; });
}

Coupling EventText::coupling(std::string_view key) const {
  return read_added_coupling(TomlTable::table(key), *scope_);
}

Constraint EventText::constraint(std::string_view key) const {
  return read_added_constraint(TomlTable::table(key), *scope_);
}

Potential EventText::potential(const NamedTerm& of) const {
  Observer observer = observer_of(scope_->team, scope_->observers, of.observer);
  if (of.mount) observer.mount = of.mount;
  return read_potential(*this, observer).potential;
}

Reference EventText::reference(AgentId agent) const {
  return read_reference(*this, scope_->team.model(agent));
}

Potential EventText::limits(std::string_view key, Between ends, std::string_view named_by) const {
  Region region = key == "formula" ? read_formula(*this, key) : read_inside(*this, key);
  if (region.sees_third())
    throw_invalid(key, "a formula of two bodies, a third is known to a coupling alone");
  if (region.is_view()) {
    region = region.seen_from(sensor_of(ends, named_by));
  } else if (has("sensor")) {
    throw_invalid("sensor", "no such key: the limit does not look through a sensor");
  }
  return checked([&] { return Potential(region); });
}

Observer EventText::observer(std::string_view key) const {
  const Observer all = observer_of(scope_->team, scope_->observers, robot(key));
  if (!all.mount && all.sensors.empty()) throw_invalid(key, "a robot with a sensor");
  return read_looking(*this, all);
}

SensorMount EventText::sensor_of(Between ends, std::string_view key) const {
  const Observer observer = read_looking(*this, observer_of(scope_->team, scope_->observers, ends.first));
  if (!has("sensor")) {
    const auto has_mount = [](const Potential& potential) { return potential.mount() != nullptr; };
    if (const Potential* const view = first_view(scope_->couplings, ends, has_mount)) return *view->mount();
  }
  if (!observer.mount) {
    throw_invalid(
        key, fmt::format("a robot with a sensor as observer, there is no [agent.{}.sensor]", observer.name));
  }
  return *observer.mount;
}

const Potential* EventText::limit_of_view(Between ends) const {
  const bool is_chosen = has("sensor");
  const Observer observer = read_looking(*this, observer_of(scope_->team, scope_->observers, ends.first));
  return first_view(scope_->couplings, ends, [&](const Potential& potential) {
    const bool through =
        !is_chosen || (potential.mount() != nullptr && *potential.mount() == *observer.mount);
    return through && potential.violation({}, {}) != -std::numeric_limits<double>::infinity();
  });
}

std::vector<std::string_view> EventText::signals() const {
  std::vector<std::string_view> names;
  for (const TimedSignal& signal : scope_->simulation.signals) names.push_back(signal.name);
  return names;
}

Coupling read_added_coupling(const TomlTable& couple, const EventScope& scope) {
  Coupling coupling = read_coupling(couple, scope.team, scope.observers);
  Team trial = scope.team;
  Coupling unnamed = coupling;
  unnamed.name.clear();
  couple.checked([&] { trial.couple(std::move(unnamed)); });
  return coupling;
}

Constraint read_added_constraint(const TomlTable& constrain, const EventScope& scope) {
  constrain.expect_only({"name", "agent", "potential", "weight"});
  const AgentId agent = EventText(constrain, scope).robot("agent");
  Constraint constraint{.term = read_potential(constrain, observer_of(scope.team, scope.observers, agent)),
                        .agent = agent,
                        .name = read_term_name(constrain)};
  Team trial = scope.team;
  constrain.checked([&] { trial.constrain(constraint.term, agent); });
  return constraint;
}

BodyId read_body(const TomlValue& value, const Team& team) {
  return team.find(value.word(body_names(team, Among::bodies), "a robot, target or obstacle"));
}

}  // namespace sightline
