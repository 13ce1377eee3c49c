#include <algorithm>

#include "sightline/events.hpp"

namespace sightline {

EventMonitor::EventMonitor(const Script& script, const Team& all)
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
  for (const ViewChoice& choice : script_.choices) choosers_.emplace_back(choice);
  triggered_.reserve(states_.size());
}

std::size_t EventMonitor::stage_of(const std::string& name) {
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

std::string_view EventMonitor::stage(std::string_view region) const noexcept {
  for (const Region& r : regions_) {
    if (r.name == region) return stages_[r.stage];
  }
  return {};
}

std::span<const std::size_t> EventMonitor::look(const EventContext& known) noexcept {
  triggered_.clear();
  ConditionState none;
  for (ViewChooser& chooser : choosers_) chooser.look({all_, known, 0.0, false, none});
  for (std::size_t i = 0; i < states_.size(); ++i) {
    State& state = states_[i];
    const bool signalled = signals_[i].exchange(false, std::memory_order_acquire);
    if (state.over || (state.stage != 0 && state.stage != region_of_stage(state.stage).stage)) continue;
    const double began = state.stage == 0 ? 0.0 : region_of_stage(state.stage).began;
    const EventInstant moment{all_, known, began, signalled, state.condition, choosers_};
    if (occurs(script_.events[i].trigger, moment)) triggered_.push_back(i);
  }
  for (const std::size_t i : triggered_) {
    states_[i].over = !script_.events[i].repeat;
    const std::size_t next = states_[i].enter;
    Region& region = region_of_stage(next);
    if (next == 0 || next == region.stage) continue;
    region.stage = next;
    region.began = known.t;
    for (State& state : states_) {
      if (state.stage != next) continue;
      state.over = false;
      state.condition = {};
    }
  }
  return triggered_;
}

bool EventMonitor::signal(std::string_view name) noexcept {
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
