#include "sightline/scenario/script_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace sightline {
namespace {

struct MeasureWords {
  const Team& team;

  std::string operator()(const DistanceOf& of) const {
    return fmt::format("the distance of {} and {}", team.name(of.a), team.name(of.b));
  }
  std::string operator()(const ViewAngleOf& of) const {
    return fmt::format("the view angle of {} to {}", team.name(of.observer), team.name(of.target));
  }
  std::string operator()(const ExcessOf& of) const {
    if (of.a == of.b) return fmt::format("the excess of {} of {}", of.potential.name(), team.name(of.a));
    return fmt::format("the excess of {} between {} and {}", of.potential.name(), team.name(of.a),
                       team.name(of.b));
  }
  std::string operator()(const NearerThan& of) const {
    return fmt::format("what {} is nearer to {} than {}", team.name(of.b), team.name(of.target),
                       team.name(of.a));
  }
  std::string operator()(const AgeOf& of) const {
    return fmt::format("the age of what is known of {}", team.name(of.body));
  }
};

struct TriggerWords {
  const Team& team;

  std::string operator()(const AtTime& at) const { return fmt::format("at {} s", at.t); }
  std::string operator()(const AfterTime& after) const { return fmt::format("after {} s", after.delay); }
  std::string operator()(const Signal& signal) const { return fmt::format("on the signal {}", signal.name); }
  std::string operator()(const Condition& when) const {
    std::string text = fmt::format("when {}", words(when));
    if (when.hysteresis > 0) text += fmt::format(", hysteresis {}", when.hysteresis);
    if (when.dwell > 0) text += fmt::format(", for {} s", when.dwell);
    return text;
  }
  std::string words(const Condition& when) const {
    const bool is_above = when.side == Condition::Side::above;
    const auto* limit = std::get_if<ExcessOf>(&when.measure);
    if (limit == nullptr || when.threshold != 0) {
      return fmt::format("{} is {} {}", std::visit(MeasureWords{team}, when.measure),
                         is_above ? "above" : "below", when.threshold);
    }
    const std::string limits =
        fmt::format("{} {}", limit->potential.name(), is_above ? "is broken" : "holds");
    if (limit->a == limit->b) return fmt::format("{} for {}", limits, team.name(limit->a));
    return fmt::format("{} between {} and {}", limits, team.name(limit->a), team.name(limit->b));
  }
};

struct ActionWords {
  const Team& team;

  std::string operator()(const RemoveBody& remove) const {
    std::string text = fmt::format("remove {}", team.name(remove.body));
    if (remove.afterwards == Afterwards::hold) text += ", which holds";
    if (remove.afterwards == Afterwards::land) text += ", which lands";
    return text;
  }
  std::string operator()(const AddBody& add) const { return fmt::format("add {}", team.name(add.body)); }
  std::string operator()(const AddCoupling& add) const {
    const Coupling& c = add.coupling;
    return fmt::format("add {} {} between {} and {}", c.term.weight, c.term.potential.name(),
                       team.name(c.between.first), team.name(c.between.second));
  }
  std::string operator()(const AddConstraint& add) const {
    const Constraint& c = add.constraint;
    return fmt::format("add {} {} of {}", c.term.weight, c.term.potential.name(), team.name(c.agent));
  }
  std::string operator()(const RemoveTerm& remove) const { return fmt::format("remove {}", remove.name); }
  std::string operator()(const RetuneTerm& retune) const {
    std::string text = fmt::format("retune {}", retune.name);
    if (retune.weight) text += fmt::format(", weight {}", *retune.weight);
    if (retune.potential) text += fmt::format(", another {}", retune.potential->name());
    return text;
  }
  std::string operator()(const RetuneAgent& retune) const {
    std::vector<std::string_view> changed;
    if (retune.Q) changed.push_back("Q");
    if (retune.R) changed.push_back("R");
    if (retune.Q_f) changed.push_back("Q_f");
    if (retune.u_ref) changed.push_back("u_ref");
    if (retune.limits) changed.push_back("limits");
    return fmt::format("retune {} of {}", fmt::join(changed, ", "), team.name(retune.agent));
  }
  std::string operator()(const SetReference& change) const {
    return fmt::format("another reference for {}", team.name(change.agent));
  }
  std::string operator()(const Observe& observe) const {
    return fmt::format("{} observes {}", team.name(observe.observer), team.name(observe.target));
  }
};

}  // namespace

std::string in_words(const Trigger& trigger, const Team& team) {
  return std::visit(TriggerWords{team}, trigger);
}

std::string in_words(const Action& action, const Team& team) { return std::visit(ActionWords{team}, action); }

std::string in_words(const TeamEvent& event, const Team& team) {
  std::string text = fmt::format("{}, {}", event.name, in_words(event.trigger, team));
  if (!event.stage.empty()) text += fmt::format(", in stage {}", event.stage);
  if (event.repeat) text += ", as often as that comes about";
  std::vector<std::string> changes;
  for (const Action& action : event.actions) changes.push_back(in_words(action, team));
  if (!event.enter.empty()) changes.push_back(fmt::format("enter stage {}", event.enter));
  text += fmt::format(": {}", fmt::join(changes, "; "));
  if (const double ramp = ramp_of(event); ramp > 0) text += fmt::format(", over {} s", ramp);
  return text;
}

}  // namespace sightline
