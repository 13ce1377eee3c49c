/// A scenario's team as its text and the log's events say it: who is there, what is in force, and what each limit says
/// of the poses.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/flight_log.hpp"
#include "tests/support/judged_term.hpp"

namespace sightline::test {

enum class Duty { steered, hold, land, absent };

class JudgedTeam {
 public:
  using Seen = FlightLog::Seen;
  struct InputLimits {
    std::vector<double> low, high;
  };

  /// Both are kept by reference.
  JudgedTeam(const toml::table& file, const FlightLog& log) : file_(file), log_(log) {
    for (const std::string& name : log.names) {
      duties_[name] = {{0.0, present_at_start(name)
                                 ? (log.bodies.at(name).is_robot ? Duty::steered : Duty::hold)
                                 : Duty::absent}};
    }
    each("couple", [&](const toml::table& at) { add_coupling(at, 0.0); });
    each("shape", [&](const toml::table& at) { add_shape(at); });
    each("constrain", [&](const toml::table& at) { add_constraint(at, 0.0); });
    for (const FlightLog::Reported& reported : log.events) {
      if (reported.kind == "event_in_force")
        occur(log.script.at(static_cast<std::size_t>(reported.value)), reported.time);
    }
  }

  const std::vector<JudgedTerm>& terms() const { return terms_; }

  const Seen* seen(const std::string& name, std::size_t k) const {
    const auto& seen = log_.bodies.at(name).seen;
    return k < seen.size() && seen[k] ? &*seen[k] : nullptr;
  }

  Duty duty(const std::string& name, double t) const {
    Duty duty = Duty::absent;
    for (const auto& [since, now] : duties_.at(name)) {
      if (since <= t + same_time) duty = now;
    }
    return duty;
  }

  /// Whether it is told to land, or does so by itself, or stands on the ground.
  bool lands(const std::string& name, double t) const {
    if (duty(name, t) == Duty::land) return true;
    return std::any_of(log_.events.begin(), log_.events.end(), [&](const FlightLog::Reported& reported) {
      return (reported.kind == "land" || reported.kind == "grounded") && reported.time <= t + same_time &&
             log_.names[static_cast<std::size_t>(reported.value)] == name;
    });
  }

  /// Whether the term is in force in the period, beyond doubt, and felt by somebody.
  bool counts(const JudgedTerm& term, std::size_t k) const {
    const double t = log_.time(k);
    if (t < term.from - same_time || t >= term.until - same_time) return false;
    if (seen(term.a, k) == nullptr || seen(term.b, k) == nullptr) return false;
    return std::any_of(term.felt_by.begin(), term.felt_by.end(),
                       [&](const std::string& robot) { return duty(robot, t) == Duty::steered; });
  }

  /// How far the limit is broken, in its unit; <= 0 where it is kept.
  double excess(const JudgedTerm& term, std::size_t k) const {
    return term.excess(*seen(term.a, k), *seen(term.b, k), sensor(term.a), log_.time(k));
  }

  /// Of the terms by which one looks at another at one time, the first one tells what is in view.
  bool is_first_view(const JudgedTerm& term) const {
    return std::none_of(terms_.begin(), terms_.end(), [&](const JudgedTerm& other) {
      return &other != &term && other.a == term.a && other.b == term.b && other.is_view();
    });
  }

  std::optional<InputLimits> input_limits(const std::string& name, double t) const {
    std::optional<InputLimits> limits;
    const toml::table& agent = *file_["agent"][name].as_table();
    if (const toml::table* over_time = agent["limits"].as_table()) {
      const std::vector<double> times = numbers(*over_time->get("times"));
      std::size_t k = 0;
      while (k + 1 < times.size() && times[k + 1] <= t) ++k;
      limits = InputLimits{numbers(*(*over_time)["u_min"].as_array()->get(k)),
                           numbers(*(*over_time)["u_max"].as_array()->get(k))};
    } else if (agent.contains("u_min") && agent.contains("u_max")) {
      limits = InputLimits{numbers(*agent.get("u_min")), numbers(*agent.get("u_max"))};
    } else if (const auto own = agent["robot"]["text"]; own["u_min"] && own["u_max"]) {
      limits = InputLimits{numbers(*own["u_min"].node()), numbers(*own["u_max"].node())};
    } else if (const auto of_model = model_limits(agent)) {
      limits = of_model;
    }
    for (const auto& [robot, since, now] : retuned_) {
      if (robot == name && since <= t + same_time) limits = now;
    }
    return limits;
  }

  /// Whether faults kept its measurements or its plan away for so long that it may land. The longest of them counts
  /// from the start, since what was refused is believed again only after some good ones.
  bool data_may_be_old(const std::string& name, double t) const {
    constexpr double settling = 0.6, rarely = 0.6;  // [s], probability
    double blind = 0.0, longest = 0.0;
    for (double at = 0.0; at <= t; at += log_.period) {
      double good = 1.0, delay = file_["simulation"]["disturbance"]["delay"].value_or(0.0);
      each_fault([&](const toml::table& fault) {
        if (at < fault["from"].value_or(0.0) || at > fault["until"].value_or(infinity) + settling) return;
        if (fault.contains("body") && fault["body"].value_or<std::string>("") != name) return;
        const std::string kind = fault["kind"].value_or<std::string>("");
        delay = std::max(delay, fault["delay"].value_or(0.0));
        if (kind == "freeze") good = 0.0;
        if (kind != "delay" && kind != "late_plan") good *= 1.0 - fault["probability"].value_or(1.0);
      });
      blind = good < 1.0 - rarely ? blind + log_.period : 0.0;
      longest = std::max({longest, blind, delay});
      if (const Seen* now = seen(name, static_cast<std::size_t>(std::llround(at / log_.period)))) {
        const double speed = std::hypot(now->v[0], now->v[1], now->v[2]);
        const bool beyond =
            std::abs(now->p[0]) > world() || std::abs(now->p[1]) > world() || std::abs(now->p[2]) > world();
        if (beyond || speed > file_["safety"]["supervisor"]["v_max"].value_or(5.0)) return true;
      }
    }
    return longest > land_after() - settling || without_plan(t) > land_after() - settling;
  }

  double hold_after() const { return file_["safety"]["supervisor"]["hold_after"].value_or(0.5); }
  double land_after() const { return file_["safety"]["supervisor"]["land_after"].value_or(2.0); }
  double world() const { return file_["safety"]["world"].value_or(100.0); }

  std::optional<double> hard_distance(const std::string& a, const std::string& b) const {
    for (const std::string& name : {a, b}) {
      for (const char* kind : {"target", "obstacle"}) {
        if (const auto own = file_[kind][name]["d_hard"].value<double>()) return own;
      }
    }
    if (!file_.contains("safety")) return std::nullopt;
    return file_["safety"]["d_hard"].value_or(0.6);
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity(), same_time = 1e-9;

  template <class Do>
  void each(const char* key, Do&& act) const {
    if (const toml::array* list = file_[key].as_array()) {
      for (const toml::node& node : *list) act(*node.as_table());
    }
  }
  template <class Do>
  void each_fault(Do&& act) const {
    if (const toml::array* list = file_["simulation"]["fault"].as_array()) {
      for (const toml::node& node : *list) act(*node.as_table());
    }
  }

  static std::vector<double> numbers(const toml::node& list) {
    std::vector<double> numbers;
    for (const toml::node& number : *list.as_array()) numbers.push_back(number.value_or(0.0));
    return numbers;
  }
  static std::vector<std::string> texts(const toml::node* list) {
    std::vector<std::string> texts;
    if (list == nullptr || !list->is_array()) return texts;
    for (const toml::node& text : *list->as_array()) texts.push_back(text.value_or<std::string>(""));
    return texts;
  }

  bool is_robot(const std::string& name) const { return log_.bodies.at(name).is_robot; }
  bool present_at_start(const std::string& name) const {
    for (const char* kind : {"agent", "target", "obstacle"}) {
      if (!file_[kind][name]["present"].value_or(true)) return false;
    }
    return true;
  }

  static std::optional<InputLimits> model_limits(const toml::table& agent) {
    const std::string robot = agent["robot"].value_or<std::string>("");
    std::vector<double> most;
    if (robot == "velocity_multirotor") {
      const auto p = agent["parameters"];
      const bool ar_drone = p["preset"].value_or<std::string>("px4") == "ar_drone";
      const double v = p["v_max"].value_or(ar_drone ? 2.863 : 3.0);
      most = {v, v, p["climb_max"].value_or(1.0), p["yaw_max"].value_or(ar_drone ? 1.6 : 0.78)};
    } else {
      const std::map<std::string, std::size_t> inputs = {{"multirotor", 4},       {"angle_multirotor", 4},
                                                         {"hover_multirotor", 4}, {"omni_rover", 3},
                                                         {"unicycle", 2},         {"point_mass", 3}};
      most.assign(inputs.contains(robot) ? inputs.at(robot) : 2, 1.0);  // else a robot that is text
    }
    std::vector<double> least;
    for (const double u : most) least.push_back(-u);
    return InputLimits{least, most};
  }

  /// The longest time up to t without a plan, by the log's statuses [s].
  double without_plan(double t) const {
    double longest = 0.0, now = 0.0;
    for (std::size_t k = 0; k < log_.status.size() && log_.time(k) <= t + same_time; ++k) {
      const std::string& status = log_.status[k];
      const bool failed = status == "not_finite" || status == "invalid_state" || status == "deadline";
      now = failed ? now + log_.period : 0.0;
      longest = std::max(longest, now);
    }
    return longest;
  }

  JudgedSensor sensor(const std::string& robot) const {
    const auto sensor = file_["agent"][robot]["sensor"];
    return {sensor["pitch"].value_or(0.5), sensor["offset"].value_or(0.17)};
  }

  // --- what is in force ---

  void add_term(const toml::table& potential, std::string a, std::string b, std::vector<std::string> felt_by,
                std::string name, double from) {
    for (const auto& [kind, keys] : potential) {
      if (kind.str() == "weight" || !keys.is_table()) continue;
      terms_.push_back({std::string(kind.str()), keys.as_table(), a, b, felt_by, name, from});
    }
  }
  std::vector<std::string> robots_of(const std::string& a, const std::string& b) const {
    std::vector<std::string> robots;
    for (const std::string& name : {a, b}) {
      if (is_robot(name)) robots.push_back(name);
    }
    return robots;
  }
  void add_coupling(const toml::table& at, double from) {
    const std::vector<std::string> ends = texts(at.get("between"));
    const auto felt = at.contains("felt_by") ? texts(at.get("felt_by")) : robots_of(ends[0], ends[1]);
    add_term(*at["potential"].as_table(), ends[0], ends[1], felt, at["name"].value_or<std::string>(""), from);
  }
  void add_constraint(const toml::table& at, double from) {
    if (at.contains("limit")) return;
    const std::string agent = at["agent"].value_or<std::string>("");
    add_term(*at["potential"].as_table(), agent, agent, {agent}, at["name"].value_or<std::string>(""), from);
  }
  void add_shape(const toml::table& at) {
    std::vector<std::pair<std::string, std::string>> pairs;
    std::vector<std::string> line = texts(at.get("chain"));
    if (at.contains("ring")) line = texts(at.get("ring"));
    for (std::size_t i = 1; i < line.size(); ++i) pairs.emplace_back(line[i], line[i - 1]);
    if (at.contains("ring")) pairs.emplace_back(line.front(), line.back());
    if (const toml::table* star = at["star"].as_table()) {
      for (const std::string& name : texts(star->get("observers")))
        pairs.emplace_back(name, (*star)["centre"].value_or<std::string>(""));
    }
    if (at.contains("all_pairs")) {
      std::vector<std::string> all = texts(at.get("all_pairs"));
      for (const std::string& name : log_.names) {
        if (at["all_pairs"].is_string() && is_robot(name)) all.push_back(name);
      }
      for (std::size_t i = 0; i < all.size(); ++i) {
        for (std::size_t j = i + 1; j < all.size(); ++j) pairs.emplace_back(all[i], all[j]);
      }
    }
    const bool relay = at.contains("nearest");
    if (relay)
      pairs = {{at["nearest"]["observers"][0].value_or<std::string>(""),
                at["nearest"]["target"].value_or<std::string>("")}};
    const bool one = relay || at["felt_by"].value_or<std::string>("both") == "observer";
    for (const auto& [a, b] : pairs) {
      const auto felt = one ? std::vector<std::string>{a} : robots_of(a, b);
      if (const toml::array* list = at["potentials"].as_array()) {
        for (const toml::node& entry : *list)
          add_term(*entry.as_table(), a, b, felt, relay ? "relay of " + a : "", 0.0);
      } else {
        add_term(*at["potential"].as_table(), a, b, felt, "", 0.0);
      }
    }
  }

  void end_terms(const std::string& name, double t) {
    for (JudgedTerm& term : terms_) {
      if (term.name == name && term.until == infinity) term.until = t;
    }
  }

  /// What an event of the script makes of the team at a time.
  void occur(const std::string& name, double t) {
    std::size_t place = 0;
    bool found = false;
    each("event", [&](const toml::table& event) {
      if (event["name"].value_or(fmt::format("event[{}]", place++)) != name) return;
      found = true;
      const double ramp = event["ramp"].value_or(event.contains("observe") ? 1.0 : 0.0);
      for (const char* key : {"remove", "add", "retune", "observe"}) {
        if (const toml::node* action = event.get(key)) act(key, *action, t, ramp);
      }
    });
    const std::size_t over = name.find(" takes over from ");
    if (found || over == std::string::npos) return;
    each("shape", [&](const toml::table& at) {
      const std::string label = at["name"].value_or<std::string>("nearest") + ": ";
      if (!at.contains("nearest") || !name.starts_with(label)) return;
      const std::string next = name.substr(label.size(), over - label.size()), last = name.substr(over + 17);
      end_terms("relay of " + last, t);
      const std::string target = at["nearest"]["target"].value_or<std::string>("");
      for (const toml::node& entry : *at["potentials"].as_array()) {
        add_term(*entry.as_table(), next, target, {next}, "relay of " + next,
                 t + at["nearest"]["ramp"].value_or(1.0));
      }
    });
  }

  void act(const std::string& key, const toml::node& action, double t, double ramp) {
    if (const toml::array* list = action.as_array()) {
      for (const toml::node& item : *list) act(key, item, t, ramp);
      return;
    }
    const auto word = [&](const char* of) { return (*action.as_table())[of].value_or<std::string>(""); };
    const std::string body = action.is_string() ? action.value_or<std::string>("")
                                                : word("agent") + word("target") + word("obstacle");
    const toml::table* at = action.as_table();
    if (key == "remove" && at != nullptr && (at->contains("couple") || at->contains("constrain"))) {
      end_terms(word("couple") + word("constrain"), t);
    } else if (key == "remove") {
      const std::string then = at != nullptr ? word("then") : "";
      duties_[body].emplace_back(t, then == "hold" ? Duty::hold : then == "land" ? Duty::land : Duty::absent);
    } else if (key == "add" && at != nullptr && at->contains("couple")) {
      add_coupling(*(*at)["couple"].as_table(), t + ramp);
    } else if (key == "add" && at != nullptr && at->contains("constrain")) {
      add_constraint(*(*at)["constrain"].as_table(), t + ramp);
    } else if (key == "add") {
      duties_[body].emplace_back(t, is_robot(body) ? Duty::steered : Duty::hold);
      for (JudgedTerm& term : terms_) {
        if ((term.a == body || term.b == body) && term.until == infinity)
          term.from = std::max(term.from, t + ramp);
      }
    } else if (key == "observe") {
      observe(word("observer"), word("target"), t, ramp);
    } else if (at->contains("agent")) {
      if (at->contains("u_min"))
        retuned_.push_back({body, t, {numbers(*at->get("u_min")), numbers(*at->get("u_max"))}});
    } else {
      retune(word("couple") + word("constrain"), *at, t, ramp);
    }
  }

  void retune(const std::string& name, const toml::table& at, double t, double ramp) {
    if (!at.contains("potential")) return;
    const auto old = std::find_if(terms_.begin(), terms_.end(), [&](const JudgedTerm& term) {
      return term.name == name && term.until == infinity;
    });
    if (old == terms_.end()) return;
    old->until = t;
    const JudgedTerm before = *old;
    add_term(*at["potential"].as_table(), before.a, before.b, before.felt_by, name, t + ramp);
  }

  /// Views and what holds the observer to its target go over; what keeps apart stays, and the new target gets the same.
  void observe(const std::string& observer, const std::string& target, double t, double ramp) {
    const auto looks = std::find_if(terms_.begin(), terms_.end(), [&](const JudgedTerm& term) {
      return term.a == observer && term.until == infinity && term.is_view();
    });
    if (looks == terms_.end()) return;
    const std::string before = looks->b;
    for (std::size_t i = 0, n = terms_.size(); i < n; ++i) {
      if (terms_[i].until != infinity || !terms_[i].joins(observer, before)) continue;
      if (terms_[i].a == before && terms_[i].is_view()) continue;
      JudgedTerm next = terms_[i];
      next.from = t + ramp;
      (next.a == before ? next.a : next.b) = target;
      std::replace(next.felt_by.begin(), next.felt_by.end(), before, target);
      if (!is_robot(target)) std::erase(next.felt_by, target);
      if (!terms_[i].keeps_apart()) {
        terms_[i].until = t;
        if (!next.felt_by.empty()) terms_.push_back(next);
      }
    }
  }

  struct Retuned {
    std::string robot;
    double since;
    InputLimits limits;
  };

  const toml::table& file_;
  const FlightLog& log_;
  std::map<std::string, std::vector<std::pair<double, Duty>>> duties_;
  std::vector<JudgedTerm> terms_;
  std::vector<Retuned> retuned_;
};

}  // namespace sightline::test
