#include "sightline/ocp/event.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "sightline/ocp/roster.hpp"

namespace sightline {
namespace {

bool at_least_zero(double value) { return value >= 0 && std::isfinite(value); }

/// What an action is about: two at one time about the same contradict each other.
struct Subject {
  const Team& all;

  std::string operator()(const RemoveBody& a) const { return body(a.body); }
  std::string operator()(const AddBody& a) const { return body(a.body); }
  std::string operator()(const AddCoupling& a) const { return term(a.coupling.name); }
  std::string operator()(const AddConstraint& a) const { return term(a.constraint.name); }
  std::string operator()(const RemoveTerm& a) const { return term(a.name); }
  std::string operator()(const RetuneTerm& a) const { return term(a.name); }
  std::string operator()(const RetuneAgent& a) const {
    return fmt::format("the tuning of {}", body(a.agent));
  }
  std::string operator()(const SetReference& a) const {
    return fmt::format("the reference of {}", body(a.agent));
  }
  std::string operator()(const Observe& a) const { return fmt::format("whom {} observes", body(a.observer)); }

  std::string body(BodyId id) const { return fmt::format("\"{}\"", all.name(id)); }
  static std::string term(const std::string& name) {
    return name.empty() ? std::string() : fmt::format("the coupling or constraint \"{}\"", name);
  }
};

class Examination {
 public:
  Examination(const Script& script, const Roster& roster)
      : events_(script.events), begins_(script.begins), roster_(roster) {
    for (std::size_t i = 0; i < events_.size(); ++i) check_numbers(i);
    check_stages();
    check_cycles();
    check_times();
  }
  std::vector<ScriptFault> faults() && { return std::move(faults_); }

 private:
  template <class... Args>
  void fault(std::size_t event, fmt::format_string<Args...> sentence, Args&&... args) {
    faults_.push_back({event, fmt::format(sentence, std::forward<Args>(args)...)});
  }

  void check_numbers(std::size_t i) {
    const TeamEvent& event = events_[i];
    if (event.ramp && !at_least_zero(*event.ramp)) fault(i, "ramp = {}, expected >= 0 s", *event.ramp);
    if (event.actions.empty() && event.enter.empty()) {
      fault(i, "the event changes nothing, expected an action or a stage to enter");
    }
    if (const auto* at = std::get_if<AtTime>(&event.trigger); at != nullptr && !at_least_zero(at->t)) {
      fault(i, "at = {}, expected >= 0 s", at->t);
    }
    if (const auto* after = std::get_if<AfterTime>(&event.trigger);
        after != nullptr && !at_least_zero(after->delay)) {
      fault(i, "after = {}, expected >= 0 s", after->delay);
    }
    const auto* when = std::get_if<Condition>(&event.trigger);
    if (event.repeat && when == nullptr && !std::holds_alternative<Signal>(event.trigger)) {
      fault(i, "repeat = true of an event with a time, expected a condition or a signal");
    }
    if (when == nullptr) return;
    if (!at_least_zero(when->hysteresis)) fault(i, "hysteresis = {}, expected >= 0", when->hysteresis);
    if (!at_least_zero(when->dwell)) fault(i, "dwell = {}, expected >= 0 s", when->dwell);
    if (!std::isfinite(when->threshold)) fault(i, "a threshold of {}, expected a number", when->threshold);
    const bool positive = !std::holds_alternative<ExcessOf>(when->measure) &&
                          !std::holds_alternative<NearerThan>(when->measure);
    if (positive && when->side == Condition::Side::below && when->threshold <= 0) {
      fault(i, "below = {}, expected > 0: a distance, an angle or an age never is below", when->threshold);
    }
    if (std::holds_alternative<ViewAngleOf>(when->measure) && when->side == Condition::Side::above &&
        when->threshold >= 3.1415926535897932) {
      fault(i, "above = {}, expected less than pi: an angle never is above", when->threshold);
    }
    if (event.repeat && when->hysteresis == 0 && when->dwell == 0) {
      fault(i,
            "a condition that repeats could come about each period, expected hysteresis > 0 or dwell > 0 s");
    }
  }

  void check_stages() {
    std::set<std::string, std::less<>> entered(begins_.begin(), begins_.end());
    for (const TeamEvent& event : events_) entered.insert(event.enter);
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const TeamEvent& event = events_[i];
      if (!entered.contains(event.stage) && !event.stage.empty()) {
        fault(i, "stage = \"{}\", expected a stage that an event enters, or \"{}\"", event.stage,
              first_stage);
      }
      if (!event.enter.empty() && event.enter == event.stage) {
        fault(i, "enter = \"{}\", expected another stage than its own", event.enter);
      }
    }
  }

  /// Whether the event can come about the moment its stage begins.
  static bool takes_no_time(const TeamEvent& event) {
    if (const auto* after = std::get_if<AfterTime>(&event.trigger)) return after->delay <= 0;
    if (const auto* when = std::get_if<Condition>(&event.trigger)) return when->dwell <= 0;
    return false;  // a time comes once, a signal from outside
  }

  /// Stages that follow each other in no time must not come back to the first.
  void check_cycles() {
    std::map<std::string, std::vector<std::size_t>> ways;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      if (!events_[i].enter.empty() && !events_[i].stage.empty() && takes_no_time(events_[i]))
        ways[events_[i].stage].push_back(i);
    }
    std::set<std::string> known;
    std::vector<std::string> path;
    const auto follow = [&](const auto& self, const std::string& stage) -> void {
      known.insert(stage);
      path.push_back(stage);
      for (const std::size_t i : ways[stage]) {
        const std::string& next = events_[i].enter;
        if (const auto back = std::find(path.begin(), path.end(), next); back != path.end()) {
          fault(
              i,
              "enter = \"{}\": the stages {} -> {} follow each other in no time, expected after or dwell > 0 "
              "s in one of them",
              next, fmt::join(back, path.end(), " -> "), next);
        } else if (!known.contains(next)) {
          self(self, next);
        }
      }
      path.pop_back();
    };
    for (const auto& [stage, events] : std::map(ways)) {
      if (!known.contains(stage)) follow(follow, stage);
    }
  }

  /// Events of fixed times happen in their order: those that cannot be are wrong, unless one that nobody can foresee
  /// is about the same.
  void check_times() {
    struct Fixed {
      double t;
      std::size_t event;
    };
    std::vector<Fixed> fixed;
    std::set<std::string> unforeseen;
    const Subject subject{roster_.all()};
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const bool at_once =
          events_[i].stage.empty() || std::count(begins_.begin(), begins_.end(), events_[i].stage) > 0;
      if (const auto* at = std::get_if<AtTime>(&events_[i].trigger); at != nullptr && at_once) {
        fixed.push_back({at->t, i});
      } else {
        for (const Action& action : events_[i].actions) unforeseen.insert(std::visit(subject, action));
      }
    }
    std::stable_sort(fixed.begin(), fixed.end(), [](const Fixed& a, const Fixed& b) { return a.t < b.t; });
    Roster trial = roster_;
    std::map<std::string, Fixed> last;
    std::map<std::pair<double, std::string_view>, std::size_t> entering;
    for (const Fixed& it : fixed) {
      const TeamEvent& event = events_[it.event];
      if (!event.enter.empty()) {
        const auto [other, first] = entering.emplace(std::pair(it.t, region_of(event.enter)), it.event);
        if (!first && events_[other->second].enter != event.enter) {
          fault(it.event, "at = {}: enter = \"{}\", and at the same time \"{}\", expected one stage", it.t,
                event.enter, events_[other->second].enter);
        }
      }
      for (const Action& action : event.actions) {
        const std::string what = std::visit(subject, action);
        if (!what.empty()) {
          const auto before = last.find(what);
          if (before != last.end() && before->second.t == it.t) {
            fault(it.event, "at = {}: {} is changed twice at one time, expected one change", it.t, what);
            continue;
          }
          last[what] = it;
        }
        const std::string refusal = trial.apply(action, it.t, ramp_of(event));
        if (!refusal.empty() && !unforeseen.contains(what)) fault(it.event, "at = {}: {}", it.t, refusal);
      }
    }
    // What lies ahead of all events, and is wrong in any order.
    for (std::size_t i = 0; i < events_.size(); ++i) {
      std::set<std::string> once;
      for (const Action& action : events_[i].actions) {
        const std::string what = std::visit(subject, action);
        if (!what.empty() && !once.insert(what).second &&
            !std::holds_alternative<AtTime>(events_[i].trigger)) {
          fault(i, "{} is changed twice at one time, expected one change", what);
        }
      }
    }
  }

  const std::vector<TeamEvent>& events_;
  const std::vector<std::string>& begins_;
  const Roster& roster_;
  std::vector<ScriptFault> faults_;
};

}  // namespace

std::string_view region_of(std::string_view stage) {
  const std::size_t colon = stage.find(':');
  return colon == std::string_view::npos ? std::string_view() : stage.substr(0, colon);
}

double ramp_of(const TeamEvent& event) {
  constexpr double of_an_observer = 1.0;
  if (event.ramp) return *event.ramp;
  const bool observes = std::any_of(event.actions.begin(), event.actions.end(), [](const Action& action) {
    return std::holds_alternative<Observe>(action);
  });
  return observes ? of_an_observer : 0.0;
}

std::vector<ScriptFault> faults_of(const Script& script, const Roster& roster) {
  return Examination(script, roster).faults();
}

}  // namespace sightline
