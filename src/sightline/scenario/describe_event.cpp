#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/ocp/apply_action.hpp"
#include "sightline/scenario/read_event.hpp"

namespace sightline {
namespace {

/// Ends of a limit, "of uav0" or "between uav0 and uav1"; `one` is the word for a limit of one robot.
std::string describe_ends(const ExcessOf& of, const Team& all, std::string_view one) {
  if (of.a == of.b) return fmt::format("{} {}", one, all.name(of.a));
  return fmt::format("between {} and {}", all.name(of.a), all.name(of.b));
}

std::string describe(const DistanceOf& of, const Team& all) {
  return fmt::format("the distance of {} and {}", all.name(of.a), all.name(of.b));
}

std::string describe(const ViewAngleOf& of, const Team& all) {
  return fmt::format("the view angle of {} to {}", all.name(of.observer), all.name(of.target));
}

std::string describe(const AgeOf& of, const Team& all) {
  return fmt::format("the age of what is known of {}", all.name(of.body));
}

std::string describe(const ExcessOf& of, const Team& all) {
  return fmt::format("the excess of {} {}", of.potential.name(), describe_ends(of, all, "of"));
}

std::string describe(const NearerThan& of, const Team& all) {
  return fmt::format("what {} is nearer to {} than {}", all.name(of.b), all.name(of.target), all.name(of.a));
}

std::string describe(const TurnedTo& of, const Team& all) {
  return fmt::format("the choice for {}", all.name(of.body));
}

std::string describe(const AtTime& at, const Team& /*all*/) { return fmt::format("at {} s", at.t); }

std::string describe(const AfterTime& after, const Team& /*all*/) {
  return fmt::format("after {} s", after.delay);
}

std::string describe(const Condition& when, const Team& all) {
  const bool is_above = when.side == Condition::Side::above;
  const auto* limit = std::get_if<ExcessOf>(&when.measure);
  const std::string measure = std::visit([&](const auto& of) { return describe(of, all); }, when.measure);
  if (std::holds_alternative<TurnedTo>(when.measure)) return fmt::format("when {} falls on this", measure);
  std::string text =
      limit != nullptr && when.threshold == 0
          ? fmt::format("when {} {} {}", limit->potential.name(), is_above ? "is broken" : "holds",
                        describe_ends(*limit, all, "for"))
          : fmt::format("when {} is {} {}", measure, is_above ? "above" : "below", when.threshold);
  if (when.hysteresis > 0) text += fmt::format(", hysteresis {}", when.hysteresis);
  if (when.dwell > 0) text += fmt::format(", for {} s", when.dwell);
  return text;
}

std::string describe(const Signal& signal, const Team& /*all*/) {
  return fmt::format("on the signal {}", signal.name);
}

std::string describe(const RemoveBody& remove, const Team& all) {
  constexpr std::array<std::string_view, 3> how = {"", ", which holds", ", which lands"};
  return fmt::format("remove {}{}", all.name(remove.body), how[static_cast<std::size_t>(remove.afterwards)]);
}

std::string describe(const RemoveTerm& remove, const Team& /*all*/) {
  return fmt::format("remove {}", remove.name);
}

std::string describe(const AddBody& add, const Team& all) {
  return fmt::format("add {}", all.name(add.body));
}

std::string describe(const AddCoupling& add, const Team& all) {
  return fmt::format("add {} {} between {} and {}", add.coupling.term.weight,
                     add.coupling.term.potential.name(), all.name(add.coupling.between.first),
                     all.name(add.coupling.between.second));
}

std::string describe(const AddConstraint& add, const Team& all) {
  return fmt::format("add {} {} of {}", add.constraint.term.weight, add.constraint.term.potential.name(),
                     all.name(add.constraint.agent));
}

std::string describe(const RetuneAgent& retune, const Team& all) {
  std::vector<std::string_view> changed;
  if (retune.Q) changed.push_back("Q");
  if (retune.R) changed.push_back("R");
  if (retune.Q_f) changed.push_back("Q_f");
  if (retune.u_ref) changed.push_back("u_ref");
  if (retune.limits) changed.push_back("limits");
  return fmt::format("retune {} of {}", fmt::join(changed, ", "), all.name(retune.agent));
}

std::string describe(const RetuneTerm& retune, const Team& /*all*/) {
  std::string text = fmt::format("retune {}", retune.name);
  if (retune.weight) text += fmt::format(", weight {}", *retune.weight);
  if (retune.potential) text += fmt::format(", another {}", retune.potential->name());
  return text;
}

std::string describe(const Observe& observe, const Team& all) {
  return fmt::format("{} observes {}", all.name(observe.observer), all.name(observe.target));
}

std::string describe(const SetReference& set, const Team& all) {
  return fmt::format("another reference for {}", all.name(set.agent));
}

std::string describe(const HandOver& turn, const Team& all) {
  return fmt::format("{} observes {}", all.name(turn.observer),
                     turn.couplings.empty() ? "no body" : all.name(turn.couplings.front().between.second));
}

std::string describe(const MoveBody& move, const Team& all) {
  return fmt::format("move {} to {:.4g}, {:.4g}, {:.4g}", all.name(move.body), move.p.x, move.p.y, move.p.z);
}

std::string describe(const SetWind& set, const Team& /*all*/) {
  const Vec3<double>& a = set.acceleration;
  return fmt::format("wind {:.4g}, {:.4g}, {:.4g}", a.x, a.y, a.z);
}

std::string describe(const InjectFault& fault, const Team& all) {
  return fmt::format("{} of {} for {} s", fault_words[static_cast<std::size_t>(fault.kind)],
                     all.name(fault.body), fault.lasts);
}

/// Whether an action only turns the soft limits of a view with its observer.
bool is_of_view_sets(const Action& action) {
  const auto* turn = std::get_if<HandOver>(&action);
  return turn != nullptr && !turn->names.empty() && turn->names.front().starts_with(name_of_view_sets);
}

}  // namespace

std::string describe(const Action& action, const Team& all) {
  return std::visit([&](const auto& it) { return describe(it, all); }, action);
}

std::string describe(const TeamEvent& event, const Team& all) {
  const auto words = [&](const auto& it) { return describe(it, all); };
  std::string text = fmt::format("{}, {}", event.name, std::visit(words, event.trigger));
  if (!event.stage.empty()) text += fmt::format(", in stage {}", event.stage);
  if (event.repeat) text += ", as often as that comes about";
  std::vector<std::string> changes;
  for (const Action& action : event.actions)
    if (!is_of_view_sets(action)) changes.push_back(describe(action, all));
  if (!event.enter.empty()) changes.push_back(fmt::format("enter stage {}", event.enter));
  text += fmt::format(": {}", fmt::join(changes, "; "));
  if (const double ramp = ramp_of(event); ramp > 0) text += fmt::format(", over {} s", ramp);
  return text;
}

}  // namespace sightline
