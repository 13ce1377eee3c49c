#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "sightline/base/range.hpp"
#include "sightline/events.hpp"

namespace sightline {
namespace {

// The subject of an action: two changes of one subject at one time contradict each other. An empty
// one contradicts nothing.

std::string of_body(const Team& all, BodyId body) { return fmt::format("\"{}\"", all.name(body)); }
std::string of_term(std::string_view name) {
  return name.empty() ? std::string() : fmt::format("the coupling or constraint \"{}\"", name);
}

std::string subject(const RemoveBody& it, const Team& all) { return of_body(all, it.body); }
std::string subject(const RemoveTerm& it, const Team& /*all*/) { return of_term(it.name); }
std::string subject(const AddBody& it, const Team& all) { return of_body(all, it.body); }
std::string subject(const AddCoupling& it, const Team& /*all*/) { return of_term(it.coupling.name); }
std::string subject(const AddConstraint& it, const Team& /*all*/) { return of_term(it.constraint.name); }
std::string subject(const RetuneAgent& it, const Team& all) {
  return fmt::format("the tuning of {}", of_body(all, it.agent));
}
std::string subject(const RetuneTerm& it, const Team& /*all*/) { return of_term(it.name); }
std::string subject(const Observe& it, const Team& all) {
  std::string target = fmt::format("the target of {}", of_body(all, it.observer));
  if (!it.through) return target;
  const SensorMount& mount = *it.through;
  return fmt::format(
      "{} through the sensor of yaw = {}, pitch = {}, roll = {}, offset = [{}, {}, {}], frame = {}, "
      "sigmas = {}",
      target, mount.yaw, mount.pitch, mount.roll, mount.offset.x, mount.offset.y, mount.offset.z,
      mount_frames[static_cast<std::size_t>(mount.frame)], mount.sigmas);
}
std::string subject(const SetReference& it, const Team& all) {
  return fmt::format("the reference of {}", of_body(all, it.agent));
}
std::string subject(const HandOver& it, const Team& /*all*/) {
  return it.names.empty() ? std::string() : of_term(it.names.front());
}
std::string subject(const MoveBody& it, const Team& all) {
  return fmt::format("the place of {}", of_body(all, it.body));
}
std::string subject(const SetWind& /*it*/, const Team& /*all*/) { return "the wind"; }
std::string subject(const InjectFault& /*it*/, const Team& /*all*/) { return {}; }

std::string subject_of(const Action& action, const Team& all) {
  return std::visit([&](const auto& it) { return subject(it, all); }, action);
}

/// Whether an action is of one of these kinds.
template <class... Kinds>
bool is_one_of(const Action& action) {
  return (std::holds_alternative<Kinds>(action) || ...);
}

/// Numbers of a trigger that are out of range, a sentence each.
std::vector<std::string> number_faults(const Trigger& trigger, bool repeats) {
  std::vector<std::string> all;
  const auto fault = [&]<class... Args>(fmt::format_string<Args...> sentence, Args&&... args) {
    all.push_back(fmt::format(sentence, std::forward<Args>(args)...));
  };
  if (const auto* at = std::get_if<AtTime>(&trigger); at != nullptr && !at_least_zero(at->t))
    fault("at = {}, expected >= 0 s", at->t);
  if (const auto* after = std::get_if<AfterTime>(&trigger); after != nullptr && !at_least_zero(after->delay))
    fault("after = {}, expected >= 0 s", after->delay);
  const auto* const when = std::get_if<Condition>(&trigger);
  if (when == nullptr) return all;
  if (!at_least_zero(when->hysteresis)) fault("hysteresis = {}, expected >= 0", when->hysteresis);
  if (!at_least_zero(when->dwell)) fault("dwell = {}, expected >= 0 s", when->dwell);
  if (!std::isfinite(when->threshold)) fault("a threshold of {}, expected a number", when->threshold);
  const bool is_angle = std::holds_alternative<ViewAngleOf>(when->measure);
  const bool is_above = when->side == Condition::Side::above;
  if ((is_angle || std::holds_alternative<DistanceOf>(when->measure) ||
       std::holds_alternative<AgeOf>(when->measure)) &&
      !is_above && when->threshold <= 0) {
    fault("below = {}, expected > 0: a distance, an angle or an age never is below", when->threshold);
  }
  if (is_angle && is_above && when->threshold >= std::numbers::pi)
    fault("above = {}, expected less than pi: an angle never is above", when->threshold);
  if (repeats && when->hysteresis == 0 && when->dwell == 0)
    fault("a condition that repeats could come about each period, expected hysteresis > 0 or dwell > 0 s");
  return all;
}

bool has_a_time(const Trigger& trigger) {
  return std::holds_alternative<AtTime>(trigger) || std::holds_alternative<AfterTime>(trigger);
}

/// Whether it can occur at the begin of its stage. A time of the run occurs once, a signal comes from
/// outside.
bool takes_no_time(const Trigger& trigger) {
  const auto* const after = std::get_if<AfterTime>(&trigger);
  const auto* const when = std::get_if<Condition>(&trigger);
  return (after != nullptr && after->delay <= 0) || (when != nullptr && when->dwell <= 0);
}

class Examination {
 public:
  Examination(const Script& script, const ActiveTeam& active_team)
      : events_(script.events), begins_(script.begins), choices_(script.choices), active_team_(active_team) {
    for (std::size_t i = 0; i < events_.size(); ++i) check_numbers(i);
    check_stages();
    check_choices();
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
    if (event.repeat && has_a_time(event.trigger))
      fault(i, "repeat = true of an event with a time, expected a condition or a signal");
    for (std::string& sentence : number_faults(event.trigger, event.repeat))
      faults_.push_back({i, std::move(sentence)});
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

  /// Rejects events that turn an observer of a choice; only the choice may.
  void check_choices() {
    for (std::size_t i = 0; i < events_.size(); ++i) {
      for (const Action& action : events_[i].actions) {
        const auto* const observe = std::get_if<Observe>(&action);
        if (observe == nullptr) continue;
        for (const ViewChoice& choice : choices_) {
          const auto& all = choice.observers;
          if (std::find(all.begin(), all.end(), observe->observer) == all.end()) continue;
          fault(i,
                "observe.observer = \"{}\", which turns by the shape \"{}\", expected a robot that no shape "
                "turns",
                active_team_.all().name(observe->observer), choice.name);
        }
      }
    }
  }

  /// Rejects cycles of stages that follow each other in no time.
  void check_cycles() {
    std::map<std::string, std::vector<std::size_t>> ways;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      if (!events_[i].enter.empty() && !events_[i].stage.empty() && takes_no_time(events_[i].trigger))
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

  /// Applies events with fixed times in their order. A rejected change is an error, unless an event
  /// of unknown time changes the same subject.
  void check_times() {
    struct Fixed {
      double t;
      std::size_t event;
    };
    std::vector<Fixed> fixed;
    std::set<std::string> unforeseen;
    for (std::size_t i = 0; i < events_.size(); ++i) {
      const bool at_once =
          events_[i].stage.empty() || std::count(begins_.begin(), begins_.end(), events_[i].stage) > 0;
      if (const auto* at = std::get_if<AtTime>(&events_[i].trigger); at != nullptr && at_once) {
        fixed.push_back({at->t, i});
      } else {
        for (const Action& action : events_[i].actions)
          unforeseen.insert(subject_of(action, active_team_.all()));
      }
    }
    std::stable_sort(fixed.begin(), fixed.end(), [](const Fixed& a, const Fixed& b) { return a.t < b.t; });
    ActiveTeam trial = active_team_;
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
        const std::string what = subject_of(action, active_team_.all());
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
    // Two changes of one subject in one event are wrong at any time.
    for (std::size_t i = 0; i < events_.size(); ++i) {
      std::set<std::string> once;
      for (const Action& action : events_[i].actions) {
        const std::string what = subject_of(action, active_team_.all());
        if (!what.empty() && !once.insert(what).second &&
            !std::holds_alternative<AtTime>(events_[i].trigger)) {
          fault(i, "{} is changed twice at one time, expected one change", what);
        }
      }
    }
  }

  const std::vector<TeamEvent>& events_;
  const std::vector<std::string>& begins_;
  const std::vector<ViewChoice>& choices_;
  const ActiveTeam& active_team_;
  std::vector<ScriptFault> faults_;
};

}  // namespace

std::string_view region_of(std::string_view stage) {
  const std::size_t colon = stage.find(':');
  return colon == std::string_view::npos ? std::string_view() : stage.substr(0, colon);
}

double ramp_of(const TeamEvent& event) {
  if (event.ramp) return *event.ramp;
  return std::any_of(event.actions.begin(), event.actions.end(), is_one_of<Observe, MoveBody, SetWind>) ? 1.0
                                                                                                        : 0.0;
}

bool changes_surroundings(const Script& script) {
  return std::any_of(script.events.begin(), script.events.end(), [](const TeamEvent& event) {
    return std::any_of(event.actions.begin(), event.actions.end(), is_one_of<MoveBody, SetWind, InjectFault>);
  });
}

std::vector<ScriptFault> faults_of(const Script& script, const ActiveTeam& active_team) {
  return Examination(script, active_team).faults();
}

}  // namespace sightline
