/// Determines once each period which events of a script happen.
#pragma once

#include <atomic>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/ocp/event_instant.hpp"

namespace sightline {

class EventMonitor {
 public:
  /// @param all  the bodies of the script
  EventMonitor(const Script& script, const Team& all);

  /// The events that happen now, in the order of the script; a stage that one of them enters begins
  /// now. Allocates nothing.
  /// @return indices in the script, valid until the next call
  std::span<const std::size_t> look(const EventContext& known) noexcept;

  /// Registers a message; the events that wait for it happen at the next look(). Thread-safe.
  /// @return whether an event of the script has this signal
  bool signal(std::string_view name) noexcept;

  /// The present stage of a region; empty if the script has none of it.
  std::string_view stage(std::string_view region = {}) const noexcept;

 private:
  struct State {
    std::size_t stage = 0, enter = 0;  // in stages_, 0: none
    bool over = false;
    ConditionState condition{};
  };

  /// The present stage of those that exclude each other.
  struct Region {
    std::string name;
    std::size_t stage = 0;
    double began = 0.0;  // [s]
  };

  std::size_t stage_of(const std::string& name);
  Region& region_of_stage(std::size_t stage) noexcept { return regions_[stage_regions_[stage]]; }

  Script script_;
  Team all_;
  std::vector<std::string> stages_;  // the first is no stage
  std::vector<State> states_;
  std::deque<std::atomic<bool>> signals_;  // of each event
  std::vector<ViewChooser> choosers_;
  std::vector<std::size_t> triggered_;
  std::vector<std::size_t> stage_regions_;  // of each stage
  std::vector<Region> regions_;
};

}  // namespace sightline
