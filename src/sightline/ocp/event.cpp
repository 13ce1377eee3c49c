#include "sightline/ocp/event.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "sightline/ocp/active_team.hpp"

namespace sightline {
namespace {

std::string subject_of(const Action& action, const Team& all) {
  return std::visit([&](const auto& it) { return it.subject(all); }, action);
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
    const auto check = [&](const auto& trigger) {
      if (event.repeat && !trigger.may_repeat) {
        fault(i, "repeat = true of an event with a time, expected a condition or a signal");
      }
      for (std::string& sentence : trigger.faults(event.repeat)) faults_.push_back({i, std::move(sentence)});
    };
    std::visit(check, event.trigger);
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

  static bool takes_no_time(const TeamEvent& event) {
    return std::visit([](const auto& trigger) { return trigger.takes_no_time(); }, event.trigger);
  }

  /// Rejects cycles of stages that follow each other in no time.
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
  double longest = 0.0;
  const auto count = [&](const auto& action) {
    if constexpr (requires { action.usual_ramp; }) longest = std::max(longest, action.usual_ramp);
  };
  for (const Action& action : event.actions) std::visit(count, action);
  return longest;
}

bool changes_surroundings(const Script& script) {
  const auto changes = [](const Action& action) {
    return std::visit(
        [](const auto& it) {
          return requires { it.changes_surroundings; };
        },
        action);
  };
  return std::any_of(script.events.begin(), script.events.end(), [&](const TeamEvent& event) {
    return std::any_of(event.actions.begin(), event.actions.end(), changes);
  });
}

std::string in_words(const TeamEvent& event, const Team& all) {
  const auto words = [&](const auto& it) { return it.describe(all); };
  std::string text = fmt::format("{}, {}", event.name, std::visit(words, event.trigger));
  if (!event.stage.empty()) text += fmt::format(", in stage {}", event.stage);
  if (event.repeat) text += ", as often as that comes about";
  std::vector<std::string> changes;
  for (const Action& action : event.actions) changes.push_back(std::visit(words, action));
  if (!event.enter.empty()) changes.push_back(fmt::format("enter stage {}", event.enter));
  text += fmt::format(": {}", fmt::join(changes, "; "));
  if (const double ramp = ramp_of(event); ramp > 0) text += fmt::format(", over {} s", ramp);
  return text;
}

std::vector<ScriptFault> faults_of(const Script& script, const ActiveTeam& active_team) {
  return Examination(script, active_team).faults();
}

}  // namespace sightline
