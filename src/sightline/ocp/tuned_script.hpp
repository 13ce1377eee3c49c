/// Events that a user adds in flight, after those of the script; they happen when they arrive.
///
/// One thread adds events, the control thread takes one per period, and other threads read their
/// state. No thread waits: an event never changes once it is counted. Appended to the scenario with
/// the times at which they happened, they are ordinary events, and a replay gives the same flight.
#pragma once

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sightline/ocp/event.hpp"

namespace sightline {

class TunedScript {
 public:
  static constexpr std::size_t room = 1000;  ///< greatest number of events of one flight

  TunedScript() : all_(room) {}

  bool is_full() const noexcept { return size() == room; }
  /// Appends an event. By one thread; not once the script is full.
  /// @param text  the keys of its [[event]] other than `at`, as in a scenario, with their line ends
  void add(TeamEvent event, std::string text) {
    const std::size_t i = size();
    all_[i] = std::make_unique<Tuned>(std::move(event), std::move(text));
    size_.store(i + 1, std::memory_order_release);
  }

  std::size_t size() const noexcept { return size_.load(std::memory_order_acquire); }
  const TeamEvent& event(std::size_t i) const noexcept { return all_[i]->event; }
  /// Time at which it happened [s]; NaN before.
  double at(std::size_t i) const noexcept { return all_[i]->at.load(std::memory_order_acquire); }
  /// Whether the team rejected it, with no change.
  bool is_ignored(std::size_t i) const noexcept { return all_[i]->ignored.load(std::memory_order_acquire); }
  /// The text as an [[event]] at t [s].
  std::string text(std::size_t i, double t) const {
    return fmt::format("\n[[event]]\nat = {}\n{}", t, all_[i]->text);
  }

  // By the control thread only.

  void occur(std::size_t i, double t) noexcept { all_[i]->at.store(t, std::memory_order_release); }
  void ignore(std::size_t i) noexcept { all_[i]->ignored.store(true, std::memory_order_release); }

 private:
  struct Tuned {
    Tuned(TeamEvent what, std::string keys) : event(std::move(what)), text(std::move(keys)) {}
    TeamEvent event;
    std::string text;
    std::atomic<double> at{std::numeric_limits<double>::quiet_NaN()};
    std::atomic<bool> ignored{false};
  };

  std::vector<std::unique_ptr<Tuned>> all_;
  std::atomic<std::size_t> size_{0};
};

/// The event of that number in a flight: of the script, then of the tuned ones; null beyond the
/// last.
/// @param tuned  null: no tuned events
inline const TeamEvent* flown_event(const Script& script, const TunedScript* tuned, std::size_t number) {
  const std::size_t n = script.events.size();
  if (number < n) return &script.events[number];
  return tuned != nullptr && number - n < tuned->size() ? &tuned->event(number - n) : nullptr;
}

}  // namespace sightline
