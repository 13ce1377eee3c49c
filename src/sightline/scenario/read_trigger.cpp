#include "sightline/scenario/read_trigger.hpp"

#include <fmt/format.h>

#include <numbers>

#include "sightline/potential/protection.hpp"
#include "sightline/scenario/read_region.hpp"

namespace sightline {
namespace {

using Side = Condition::Side;

constexpr std::string_view above = "above", below = "below";

/// Never smaller than 0, and where it has a largest value never larger.
struct Scale {
  std::string_view unit;
  double largest;
};

/// `hysteresis` and `dwell`: within them the condition can begin and end to hold.
void read_settling(const TomlTable& at, const EventScope& scope, Condition& when, const Scale* scale) {
  if (at.has("hysteresis")) when.hysteresis = at.number("hysteresis", not_negative(">= 0"));
  if (scale != nullptr && at.has("hysteresis")) {
    const bool ends = when.side == Side::above ? when.hysteresis < when.threshold
                                               : when.threshold + when.hysteresis < scale->largest;
    if (!ends) {
      at.refuse("hysteresis",
                fmt::format("less than {} {}, or the condition never becomes false",
                            when.side == Side::above ? when.threshold : scale->largest - when.threshold,
                            scale->unit));
    }
  }
  if (at.has("dwell")) when.dwell = at.number("dwell", not_negative(">= 0 s"));
  if (when.dwell >= scope.simulation.duration) {
    at.refuse("dwell", fmt::format("less than simulation.duration = {} s, or the event never comes about",
                                   scope.simulation.duration));
  }
}

/// `above` or `below`.
void read_threshold(const TomlTable& at, const Range& range, Condition& when) {
  if (at.has(above) == at.has(below)) at.refuse("exactly one of above, below");
  when.side = at.has(above) ? Side::above : Side::below;
  when.threshold = at.number(at.has(above) ? above : below, range);
}

void read_scaled(const TomlTable& at, std::string_view key, const Range& range, const Scale& scale,
                 const EventScope& scope, Condition& when) {
  at.expect_only({key, above, below, "hysteresis", "dwell"});
  read_threshold(at, range, when);
  read_settling(at, scope, when, &scale);
}

const SensorMount& mount_of(const TomlTable& at, std::string_view key, BodyId body, const EventScope& scope) {
  const auto i = static_cast<std::size_t>(body.index);
  if (i >= scope.observers.size() || !scope.observers[i].mount) {
    at.refuse(key, fmt::format("a robot with a sensor as observer, there is no [agent.{}.sensor]",
                               scope.team.name(body)));
  }
  return *scope.observers[i].mount;
}

Between read_two(const TomlTable& at, std::string_view key, const EventScope& scope) {
  const std::vector<BodyId> ends = bodies_named(at, key, 2, scope.team);
  if (ends[0] == ends[1]) at.refuse(key, "two different bodies");
  return {ends[0], ends[1]};
}

// --- what a condition looks at ---

constexpr double pi = std::numbers::pi;
constexpr Range angle_range = {std::numeric_limits<double>::min(), pi*(1 - 1e-15), "in (0, pi) rad"};

Condition read_distance(const TomlTable& at, const EventScope& scope) {
  const Between ends = read_two(at, "distance", scope);
  Condition when{.measure = DistanceOf{ends.first, ends.second}};
  read_scaled(at, "distance", positive("> 0 m"), {"m", largest_number}, scope, when);
  return when;
}

Condition read_angle(const TomlTable& at, const EventScope& scope) {
  const Between ends = read_two(at, "angle", scope);
  Condition when{.measure = ViewAngleOf{ends.first, ends.second, mount_of(at, "angle", ends.first, scope)}};
  read_scaled(at, "angle", angle_range, {"rad", pi}, scope, when);
  return when;
}

Condition read_age(const TomlTable& at, const EventScope& scope) {
  Condition when{.measure = AgeOf{read_body(at.value("age", "the name of a body"), scope.team)}};
  read_scaled(at, "age", positive("> 0 s"), {"s", largest_number}, scope, when);
  return when;
}

/// The limits of a region, seen by `agent` alone or from the first of `between`.
ExcessOf excess_of(const TomlTable& at, Region region, const EventScope& scope) {
  if (at.has("agent") == at.has("between")) at.refuse("exactly one of between, agent");
  Between ends;
  if (at.has("agent")) {
    const std::string name = read_name(at, "agent", scope.team, Among::robots, "a robot");
    ends.first = ends.second = scope.team.find(name);
  } else {
    ends = read_two(at, "between", scope);
  }
  if (region.is_view()) {
    const std::string_view key = at.has("agent") ? "agent" : "between";
    region = region.seen_from(mount_of(at, key, ends.first, scope));
  }
  return {at.checked([&] { return Potential(region); }), ends.first, ends.second};
}

Condition read_within(const TomlTable& at, const EventScope& scope) {
  at.expect_only({"region", "between", "agent", "parameters", "hysteresis", "dwell"});
  Condition when{.measure = excess_of(at, read_inside(at, "region"), scope), .side = Side::below};
  read_settling(at, scope, when, nullptr);
  return when;
}

Condition read_formula_of(const TomlTable& at, const EventScope& scope) {
  at.expect_only({"formula", "between", "agent", "parameters", above, below, "hysteresis", "dwell"});
  Condition when{.measure = excess_of(at, read_formula(at, "formula"), scope)};
  read_threshold(at, any_number(), when);
  read_settling(at, scope, when, nullptr);
  return when;
}

using ReadCondition = Condition (*)(const TomlTable& at, const EventScope& scope);
constexpr std::array measures = {
    Named<ReadCondition>{"distance", read_distance},
    Named<ReadCondition>{"angle", read_angle},
    Named<ReadCondition>{"age", read_age},
    Named<ReadCondition>{"region", read_within},
    Named<ReadCondition>{"formula", read_formula_of},
};

// --- triggers ---

Trigger read_at(const TomlTable& event, const EventScope&) {
  return AtTime{event.number("at", not_negative(">= 0 s"))};
}

Trigger read_after(const TomlTable& event, const EventScope&) {
  return AfterTime{event.number("after", not_negative(">= 0 s"))};
}

Trigger read_when(const TomlTable& event, const EventScope& scope) {
  constexpr std::string_view expected = "a table with distance, angle, age, region or formula";
  const TomlTable at = event.table("when", expected);
  const std::string_view measure =
      at.choice(names(measures), {above, below, "between", "agent", "parameters", "hysteresis", "dwell"});
  return find(measures, measure)(at, scope);
}

/// By the limit of the coupling that looks at the target, or by an angle of its own.
Condition read_view(const TomlTable& event, std::string_view key, Side side, const EventScope& scope) {
  const TomlTable at = event.table(key, "a table with observer and target");
  at.expect_only({"observer", "target", "alpha", "hysteresis", "dwell"});
  const BodyId observer = scope.team.find(read_name(at, "observer", scope.team, Among::robots, "a robot"));
  const BodyId target = read_body(at.value("target", "the name of a body"), scope.team);
  if (observer == target) at.refuse("target", "another body than observer");
  const SensorMount& mount = mount_of(at, "observer", observer, scope);
  Condition when{.measure = ViewAngleOf{observer, target, mount}, .side = side};
  if (at.has("alpha")) {
    when.threshold = at.number("alpha", angle_range);
    constexpr Scale angle = {"rad", pi};
    read_settling(at, scope, when, &angle);
    return when;
  }
  const auto looks = std::find_if(scope.couplings.begin(), scope.couplings.end(), [&](const Coupling& c) {
    const Potential& potential = c.term.potential;
    return c.between.first == observer && c.between.second == target && watches(potential) &&
           potential.violation({}, {}) != -std::numeric_limits<double>::infinity();
  });
  if (looks == scope.couplings.end()) {
    at.refuse("alpha", fmt::format("an angle of view [rad], no coupling of \"{}\" looks at \"{}\"",
                                   scope.team.name(observer), scope.team.name(target)));
  }
  when.measure = ExcessOf{looks->term.potential, observer, target};
  read_settling(at, scope, when, nullptr);
  return when;
}

Trigger read_lost(const TomlTable& event, const EventScope& scope) {
  return read_view(event, "lost", Side::above, scope);
}

Trigger read_seen(const TomlTable& event, const EventScope& scope) {
  return read_view(event, "seen", Side::below, scope);
}

Trigger read_signal(const TomlTable& event, const EventScope& scope) {
  std::vector<std::string_view> known;
  for (const TimedSignal& signal : scope.simulation.signals) known.push_back(signal.name);
  if (known.empty()) event.refuse("signal", "a signal of simulation.signal, there is none");
  return Signal{std::string(event.word("signal", known, "a signal of simulation.signal"))};
}

using ReadTrigger = Trigger (*)(const TomlTable& event, const EventScope& scope);
constexpr std::array triggers = {
    Named<ReadTrigger>{"at", read_at},     Named<ReadTrigger>{"after", read_after},
    Named<ReadTrigger>{"when", read_when}, Named<ReadTrigger>{"lost", read_lost},
    Named<ReadTrigger>{"seen", read_seen}, Named<ReadTrigger>{"signal", read_signal},
};

}  // namespace

BodyId read_body(const TomlValue& value, const Team& team) {
  return team.find(value.word(body_names(team, Among::bodies), "a robot, target or obstacle"));
}

Trigger read_trigger(const TomlTable& event, const EventScope& scope,
                     std::initializer_list<std::string_view> others) {
  return find(triggers, event.choice(names(triggers), others))(event, scope);
}

}  // namespace sightline
