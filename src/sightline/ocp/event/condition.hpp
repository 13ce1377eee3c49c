/// Triggers `when = { distance = ["uav0", "uav1"], below = 1.0 }`, `lost = { observer = ..., target
/// = ... }`, `seen = ...`.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "sightline/base/same_time.hpp"
#include "sightline/ocp/event/kinds.hpp"
#include "sightline/ocp/event/measure.hpp"

namespace sightline {

/// Holds once the measure has been beyond the threshold for `dwell`; ends once the measure has
/// returned by more than `hysteresis`.
struct Condition {
  enum class Side { above, below };
  static constexpr std::array<std::string_view, 3> keys = {"when", "lost", "seen"};
  static constexpr bool may_repeat = true;

  Measure measure;
  Side side = Side::above;
  double threshold = 0.0;
  double hysteresis = 0.0;  ///< in the measure's unit, >= 0
  double dwell = 0.0;       ///< [s], >= 0

  std::vector<std::string> faults(bool repeats) const;
  bool takes_no_time() const { return dwell <= 0; }
  bool occurs(const EventInstant& moment) const noexcept;
  std::string describe(const Team& all) const;
  std::vector<BodyId> bodies() const {
    return std::visit([](const auto& of) { return of.bodies(); }, measure);
  }

  template <class Text>
  static Condition read(const Text& event, std::string_view key);

 private:
  template <class Text>
  static Condition read_when(const Text& when);
  template <class Text>
  static Condition read_view(const Text& view, Side side);
  template <class Text>
  void read_threshold(const Text& at, const Range& range);
  template <class Text>
  void read_settling(const Text& at, const MeasureScale& scale);
};

inline std::vector<std::string> Condition::faults(bool repeats) const {
  std::vector<std::string> all;
  if (!at_least_zero(hysteresis)) all.push_back(fmt::format("hysteresis = {}, expected >= 0", hysteresis));
  if (!at_least_zero(dwell)) all.push_back(fmt::format("dwell = {}, expected >= 0 s", dwell));
  if (!std::isfinite(threshold))
    all.push_back(fmt::format("a threshold of {}, expected a number", threshold));
  const std::optional<double> largest =
      std::visit([](const auto& of) { return std::decay_t<decltype(of)>::scale({}).largest; }, measure);
  if (largest && side == Side::below && threshold <= 0) {
    all.push_back(
        fmt::format("below = {}, expected > 0: a distance, an angle or an age never is below", threshold));
  }
  if (std::holds_alternative<ViewAngleOf>(measure) && side == Side::above && threshold >= *largest) {
    all.push_back(fmt::format("above = {}, expected less than pi: an angle never is above", threshold));
  }
  if (repeats && hysteresis == 0 && dwell == 0) {
    all.emplace_back(
        "a condition that repeats could come about each period, expected hysteresis > 0 or dwell > 0 s");
  }
  return all;
}

inline bool Condition::occurs(const EventInstant& moment) const noexcept {
  const double value = std::visit([&](const auto& of) { return of.value(moment); }, measure);
  const double beyond = side == Side::above ? value - threshold : threshold - value;
  auto& [holds, fired, since] = moment.condition;
  const bool held = holds;
  holds = held ? beyond >= -hysteresis : beyond > 0;  // false for NaN
  if (!holds) fired = false;
  if (holds && !held) since = moment.known.t;
  if (!holds || fired || moment.known.t - since < dwell - same_time) return false;
  fired = true;
  return true;
}

inline std::string Condition::describe(const Team& all) const {
  const bool is_above = side == Side::above;
  const auto* limit = std::get_if<ExcessOf>(&measure);
  std::string text;
  if (limit != nullptr && threshold == 0) {
    text = fmt::format("when {}", limit->limit_words(all, is_above));
  } else if (const auto* turned = std::get_if<TurnedTo>(&measure)) {
    text = fmt::format("when {} falls on this", turned->describe(all));
    return text;
  } else {
    text =
        fmt::format("when {} is {} {}", std::visit([&](const auto& of) { return of.describe(all); }, measure),
                    is_above ? "above" : "below", threshold);
  }
  if (hysteresis > 0) text += fmt::format(", hysteresis {}", hysteresis);
  if (dwell > 0) text += fmt::format(", for {} s", dwell);
  return text;
}

template <class Text>
Condition Condition::read(const Text& event, std::string_view key) {
  if (key == "when")
    return read_when(event.table(key, "a table with distance, angle, age, region or formula"));
  return read_view(event.table(key, "a table with observer and target"),
                   key == "lost" ? Side::above : Side::below);
}

template <class Text>
Condition Condition::read_when(const Text& when) {
  std::vector<std::string_view> measures, beside = {"above", "below"};
  for_each_kind<Measure>([&]<class M>(Kind<M>) {
    if constexpr (requires { M::keys; }) {
      measures.insert(measures.end(), M::keys.begin(), M::keys.end());
      for (const std::string_view other : M::scale(M::keys[0]).beside) beside.push_back(other);
    }
  });
  beside.insert(beside.end(), {"hysteresis", "dwell"});
  const std::string_view key = when.choice(measures, beside);

  std::optional<Condition> condition;
  for_each_kind<Measure>([&]<class M>(Kind<M>) {
    if constexpr (requires { M::keys; }) {
      if (!contains(M::keys, key)) return;
      const MeasureScale scale = M::scale(key);
      std::vector<std::string_view> known = {key, "hysteresis", "dwell"};
      known.insert(known.end(), scale.beside.begin(), scale.beside.end());
      if (scale.threshold) known.insert(known.end(), {"above", "below"});
      when.expect_only(known);
      Condition& read = condition.emplace(Condition{.measure = M::read(when, key), .side = Side::below});
      if (scale.threshold) read.read_threshold(when, *scale.threshold);
      read.read_settling(when, scale);
    }
  });
  return std::move(*condition);
}

/// Reads a view, by the limit of the coupling that views the target, or by an angle of its own.
template <class Text>
Condition Condition::read_view(const Text& view, Side side) {
  view.expect_only({"observer", "target", "alpha", "hysteresis", "dwell"});
  const BodyId observer = view.robot("observer"), target = view.body("target", "the name of a body");
  if (observer == target) view.throw_invalid("target", "another body than observer");
  const SensorMount mount = view.sensor_of(observer, "observer");
  if (view.has("alpha")) {
    Condition condition{.measure = ViewAngleOf{observer, target, mount}, .side = side};
    condition.threshold = view.number("alpha", ViewAngleOf::range);
    condition.read_settling(view, ViewAngleOf::scale("angle"));
    return condition;
  }
  const Potential* const limit = view.limit_of_view(observer, target);
  if (limit == nullptr) {
    view.throw_invalid("alpha", fmt::format("an angle of view [rad], no coupling of \"{}\" observes \"{}\"",
                                            view.name(observer), view.name(target)));
  }
  Condition condition{.measure = ExcessOf{*limit, observer, target}, .side = side};
  condition.read_settling(view, {});
  return condition;
}

/// Reads `above` or `below`.
template <class Text>
void Condition::read_threshold(const Text& at, const Range& range) {
  if (at.has("above") == at.has("below")) at.throw_invalid("exactly one of above, below");
  if (at.has("above")) side = Side::above;
  threshold = at.number(at.has("above") ? "above" : "below", range);
}

/// Reads `hysteresis` and `dwell`; rejects values for which the condition can never end or never
/// occur.
template <class Text>
void Condition::read_settling(const Text& at, const MeasureScale& scale) {
  if (at.has("hysteresis")) hysteresis = at.number("hysteresis", not_negative(">= 0"));
  if (scale.largest && at.has("hysteresis")) {
    const double room = side == Side::above ? threshold : *scale.largest - threshold;
    if (hysteresis >= room) {
      at.throw_invalid("hysteresis", fmt::format("less than {} {}, or the condition never becomes false",
                                                 room, scale.unit));
    }
  }
  if (at.has("dwell")) dwell = at.number("dwell", not_negative(">= 0 s"));
  if (dwell >= at.duration()) {
    at.throw_invalid(
        "dwell",
        fmt::format("less than simulation.duration = {} s, or the event never comes about", at.duration()));
  }
}

}  // namespace sightline
