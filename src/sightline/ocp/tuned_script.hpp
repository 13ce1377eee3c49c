/// Events that somebody makes while the team flies, behind those of its script: they happen as they come.
///
/// One thread adds them, the control thread takes one a period, and others read what became of them. Nobody waits for anybody: an event
/// never changes once it is counted. Written behind the scenario with the times at which they happened, they are events like any others,
/// and the flight is the same.
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
  static constexpr std::size_t room = 1000;  ///< events of one flight

  TunedScript() : all_(room) {}

  bool is_full() const noexcept { return size() == room; }
  /// One thread; not once it is full.
  /// @param text  the keys of its [[event]] beside `at`, as a scenario has them, with their line ends
  void add(TeamEvent event, std::string text) {
    const std::size_t i = size();
    all_[i] = std::make_unique<Tuned>(std::move(event), std::move(text));
    size_.store(i + 1, std::memory_order_release);
  }

  std::size_t size() const noexcept { return size_.load(std::memory_order_acquire); }
  const TeamEvent& event(std::size_t i) const noexcept { return all_[i]->event; }
  /// When it happened [s]; not a number before.
  double at(std::size_t i) const noexcept { return all_[i]->at.load(std::memory_order_acquire); }
  /// Whether it could not be, and changed nothing.
  bool is_ignored(std::size_t i) const noexcept { return all_[i]->ignored.load(std::memory_order_acquire); }
  /// As an [[event]] at t [s].
  std::string text(std::size_t i, double t) const {
    return fmt::format("\n[[event]]\nat = {}\n{}", t, all_[i]->text);
  }

  // The control thread.

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

/// The event of that number in a flight: of the script, then of what was tuned; none where there is no such.
/// @param tuned  none: nothing is
inline const TeamEvent* flown_event(const Script& script, const TunedScript* tuned, std::size_t number) {
  const std::size_t n = script.events.size();
  if (number < n) return &script.events[number];
  return tuned != nullptr && number - n < tuned->size() ? &tuned->event(number - n) : nullptr;
}

}  // namespace sightline
