#include "sightline/ocp/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/base/same_time.hpp"

namespace sightline {
namespace {

/// The measure's value now; not a number where a body is absent.
struct Value {
  const Team& all;
  const Watch::View& view;

  bool is_there(BodyId body) const {
    return view.presence.empty() || view.presence[at(body)] != Presence::absent;
  }
  /// A robot that brakes or sinks takes over nothing, and is relieved.
  bool is_on_duty(BodyId body) const {
    return view.presence.empty() || view.presence[at(body)] == Presence::steered;
  }
  Sight<double> sight(BodyId body) const {
    const double* const u = all.is_agent(body) ? view.u.data() + all.input_offset(body) : nullptr;
    return all.model(body).sight(view.x.data() + all.state_offset(body), u);
  }
  static double none() { return std::numeric_limits<double>::quiet_NaN(); }

  double operator()(const DistanceOf& of) const {
    return is_there(of.a) && is_there(of.b) ? norm(sight(of.a).p - sight(of.b).p) : none();
  }
  double operator()(const ViewAngleOf& of) const {
    if (!is_there(of.observer) || !is_there(of.target)) return none();
    return view_angle(of.mount, sight(of.observer), sight(of.target).p);
  }
  double operator()(const ExcessOf& of) const {
    if (!is_there(of.a) || !is_there(of.b)) return none();
    return of.potential.violation(sight(of.a), sight(of.b), view.t);
  }
  double operator()(const NearerThan& of) const {
    if (!is_on_duty(of.b) || !is_there(of.target)) return none();
    if (!is_on_duty(of.a)) return std::numeric_limits<double>::infinity();
    const Vec3<double> target = sight(of.target).p;
    return norm(sight(of.a).p - target) - norm(sight(of.b).p - target);
  }
  double operator()(const AgeOf& of) const {
    if (!is_there(of.body)) return none();
    return view.ages.empty() ? 0.0 : view.ages[at(of.body)];
  }
};

}  // namespace

Watch::Watch(const Script& script, const Team& all)
    : script_(script), all_(all), signals_(script.events.size()) {
  (void)stage_of("");
  for (const std::string& first : script_.begins) {
    const std::size_t stage = stage_of(first);
    region_of_stage(stage).stage = stage;
  }
  for (const TeamEvent& event : script_.events) {
    State& state = states_.emplace_back();
    state.stage = stage_of(event.stage);
    state.enter = stage_of(event.enter);
  }
  happening_.reserve(states_.size());
}

std::size_t Watch::stage_of(const std::string& name) {
  const auto found = std::find(stages_.begin(), stages_.end(), name);
  if (found != stages_.end()) return static_cast<std::size_t>(found - stages_.begin());
  stages_.push_back(name);
  const std::string_view region = region_of(name);
  const auto known =
      std::find_if(regions_.begin(), regions_.end(), [&](const Region& r) { return r.name == region; });
  stage_regions_.push_back(static_cast<std::size_t>(known - regions_.begin()));
  if (known == regions_.end()) regions_.push_back({.name = std::string(region)});
  return stages_.size() - 1;
}

std::string_view Watch::stage(std::string_view region) const noexcept {
  for (const Region& r : regions_) {
    if (r.name == region) return stages_[r.stage];
  }
  return {};
}

std::span<const std::size_t> Watch::look(const View& view) noexcept {
  happening_.clear();
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const State& state = states_[i];
    const bool signalled = signals_[i].exchange(false, std::memory_order_acquire);
    if (state.over || (state.stage != 0 && state.stage != region_of_stage(state.stage).stage)) continue;
    if (std::holds_alternative<Signal>(script_.events[i].trigger) ? signalled : happens(i, view)) {
      happening_.push_back(i);
    }
  }
  for (const std::size_t i : happening_) {
    states_[i].over = !script_.events[i].repeat;
    const std::size_t next = states_[i].enter;
    Region& region = region_of_stage(next);
    if (next == 0 || next == region.stage) continue;
    region.stage = next;
    region.began = view.t;
    for (State& state : states_) {
      if (state.stage == next) state.over = state.holds = state.told = false;
    }
  }
  return happening_;
}

bool Watch::happens(std::size_t event, const View& view) noexcept {
  const Trigger& trigger = script_.events[event].trigger;
  State& state = states_[event];
  if (const auto* at = std::get_if<AtTime>(&trigger)) return view.t >= at->t - same_time;
  if (const auto* after = std::get_if<AfterTime>(&trigger)) {
    const double began = state.stage == 0 ? 0.0 : region_of_stage(state.stage).began;
    return view.t - began >= after->delay - same_time;
  }
  const auto* when = std::get_if<Condition>(&trigger);
  return when != nullptr && comes_about(*when, state, view);
}

bool Watch::comes_about(const Condition& when, State& state, const View& view) noexcept {
  const double value = std::visit(Value{all_, view}, when.measure);
  const double beyond = when.side == Condition::Side::above ? value - when.threshold : when.threshold - value;
  const bool held = state.holds;
  state.holds = held ? beyond >= -when.hysteresis : beyond > 0;  // false for what is not a number
  if (!state.holds) state.told = false;
  if (state.holds && !held) state.since = view.t;
  if (!state.holds || state.told || view.t - state.since < when.dwell - same_time) return false;
  state.told = true;
  return true;
}

bool Watch::signal(std::string_view name) noexcept {
  bool known = false;
  for (std::size_t i = 0; i < script_.events.size(); ++i) {
    const auto* signal = std::get_if<Signal>(&script_.events[i].trigger);
    if (signal == nullptr || signal->name != name) continue;
    known = true;
    signals_[i].store(true, std::memory_order_release);
  }
  return known;
}

}  // namespace sightline
