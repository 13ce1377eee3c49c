#include <fmt/format.h>

#include <limits>
#include <numbers>
#include <optional>

#include "sightline/scenario/event_text.hpp"

namespace sightline {
namespace {

/// A measure of `when`: its key, its threshold and the further keys of its table.
struct MeasureKey {
  std::string_view key;
  Measure (*read)(const EventText& when, std::string_view key);
  std::optional<Range> threshold{};  ///< none: the measure is a limit, which holds below 0
  std::string_view unit{};
  std::optional<double> largest{};  ///< the measure lies between 0 and this; none: unbounded
  std::vector<std::string_view> beside{};
};

constexpr Range view_angle_range = {std::numeric_limits<double>::min(), std::numbers::pi*(1 - 1e-15),
                                    "in (0, pi) rad"};

Measure read_distance(const EventText& when, std::string_view key) {
  const Between ends = when.two_bodies(key);
  return DistanceOf{ends.first, ends.second};
}

Measure read_view_angle(const EventText& when, std::string_view key) {
  const Between ends = when.two_bodies(key);
  return ViewAngleOf{ends.first, ends.second, when.sensor_of(ends, key)};
}

Measure read_age(const EventText& when, std::string_view key) {
  return AgeOf{when.body(key, "the name of a body")};
}

Measure read_excess(const EventText& when, std::string_view key) {
  if (when.has("agent") == when.has("between")) when.throw_invalid("exactly one of between, agent");
  const std::string_view ends_key = when.has("agent") ? "agent" : "between";
  const Between ends = when.has("agent") ? when.one_robot(ends_key) : when.two_bodies(ends_key);
  return ExcessOf{when.limits(key, ends, ends_key), ends.first, ends.second};
}

std::vector<MeasureKey> measure_keys() {
  const std::vector<std::string_view> of_limit = {"between", "agent", "parameters", "sensor"};
  return {{"distance", read_distance, positive("> 0 m"), "m", largest_number},
          {"angle", read_view_angle, view_angle_range, "rad", std::numbers::pi, {"sensor"}},
          {"age", read_age, positive("> 0 s"), "s", largest_number},
          {.key = "region", .read = read_excess, .beside = of_limit},
          {.key = "formula", .read = read_excess, .threshold = any_number(), .beside = of_limit}};
}

/// Reads `hysteresis` and `dwell`; rejects values for which the condition can never end or never
/// occur.
/// @param largest  of the measure, in its unit
void read_settling(const EventText& at, Condition& condition, std::optional<double> largest = {},
                   std::string_view unit = {}) {
  if (at.has("hysteresis")) condition.hysteresis = at.number("hysteresis", not_negative(">= 0"));
  if (largest && at.has("hysteresis")) {
    const double room =
        condition.side == Condition::Side::above ? condition.threshold : *largest - condition.threshold;
    if (condition.hysteresis >= room) {
      at.throw_invalid("hysteresis",
                       fmt::format("less than {} {}, or the condition never becomes false", room, unit));
    }
  }
  if (at.has("dwell")) condition.dwell = at.number("dwell", not_negative(">= 0 s"));
  if (condition.dwell >= at.duration()) {
    at.throw_invalid(
        "dwell",
        fmt::format("less than simulation.duration = {} s, or the event never comes about", at.duration()));
  }
}

Trigger read_when(const EventText& event, std::string_view key) {
  const EventText when = event.table(key, "a table with distance, angle, age, region or formula");
  const std::vector<MeasureKey> measures = measure_keys();
  std::vector<std::string_view> keys;
  for (const MeasureKey& measure : measures) keys.push_back(measure.key);
  const std::string_view chosen = when.choice(
      keys, {"above", "below", "between", "agent", "parameters", "sensor", "hysteresis", "dwell"});
  const MeasureKey& of = *std::find_if(measures.begin(), measures.end(),
                                       [&](const MeasureKey& measure) { return measure.key == chosen; });
  std::vector<std::string_view> known = {chosen, "hysteresis", "dwell"};
  known.insert(known.end(), of.beside.begin(), of.beside.end());
  if (of.threshold) known.insert(known.end(), {"above", "below"});
  when.expect_only(known);
  Condition condition{.measure = of.read(when, chosen), .side = Condition::Side::below};
  if (of.threshold) {
    if (when.has("above") == when.has("below")) when.throw_invalid("exactly one of above, below");
    if (when.has("above")) condition.side = Condition::Side::above;
    condition.threshold = when.number(when.has("above") ? "above" : "below", *of.threshold);
  }
  read_settling(when, condition, of.largest, of.unit);
  return condition;
}

/// Reads a view, by the limit of the coupling that views the target, or by an angle of its own.
Trigger read_view(const EventText& event, std::string_view key) {
  const EventText view = event.table(key, "a table with observer and target");
  const Condition::Side side = key == "lost" ? Condition::Side::above : Condition::Side::below;
  view.expect_only({"observer", "target", "alpha", "sensor", "hysteresis", "dwell"});
  const BodyId observer = view.robot("observer"), target = view.body("target", "the name of a body");
  if (observer == target) view.throw_invalid("target", "another body than observer");
  const SensorMount mount = view.sensor_of({observer, target}, "observer");
  if (view.has("alpha")) {
    Condition condition{.measure = ViewAngleOf{observer, target, mount}, .side = side};
    condition.threshold = view.number("alpha", view_angle_range);
    read_settling(view, condition, std::numbers::pi, "rad");
    return condition;
  }
  const Potential* const limit = view.limit_of_view({observer, target});
  if (limit == nullptr) {
    view.throw_invalid("alpha", fmt::format("an angle of view [rad], no coupling of \"{}\" observes \"{}\"",
                                            view.name(observer), view.name(target)));
  }
  Condition condition{.measure = ExcessOf{*limit, observer, target}, .side = side};
  read_settling(view, condition);
  return condition;
}

Trigger read_at_time(const EventText& event, std::string_view key) {
  return AtTime{event.number(key, time_range)};
}

Trigger read_after_time(const EventText& event, std::string_view key) {
  return AfterTime{event.number(key, time_range)};
}

Trigger read_signal(const EventText& event, std::string_view key) {
  const std::vector<std::string_view> known = event.signals();
  if (known.empty()) event.throw_invalid(key, "a signal of simulation.signal, there is none");
  return Signal{std::string(event.word(key, known, "a signal of simulation.signal"))};
}

constexpr std::array<Named<Trigger (*)(const EventText&, std::string_view)>, 6> trigger_keys = {
    {{"at", read_at_time},
     {"after", read_after_time},
     {"when", read_when},
     {"lost", read_view},
     {"seen", read_view},
     {"signal", read_signal}}};

}  // namespace

Trigger read_trigger(const TomlTable& event, const EventScope& scope,
                     std::initializer_list<std::string_view> others) {
  const std::string_view key = event.choice(names(trigger_keys), others);
  return find(trigger_keys, key)(EventText(event, scope), key);
}

}  // namespace sightline
