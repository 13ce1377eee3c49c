/// What a person may ask of a flight while it goes on, and what is answered. No messages.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

namespace sightline::dds {

/// Where a flight is, for who asks.
enum class FlightPhase : std::uint8_t {
  checking,    ///< robots are waited for
  waiting,     ///< all are ready, and a person is to let them take off
  taking_off,  ///< until all hold
  task,
  landing,
  over,
};

struct CallAnswer {
  bool success = false;
  std::string_view message{};
};

/// By any thread, without locks. What was asked twice is done once.
class OperatorCalls {
 public:
  CallAnswer start() noexcept;      ///< take off, where that waits for a person
  CallAnswer stop() noexcept;       ///< end the task: all land
  CallAnswer land() noexcept;       ///< at any time
  CallAnswer emergency() noexcept;  ///< stop the motors of all that this program armed

  // Of the flight.
  void is_at(FlightPhase phase) noexcept { phase_.store(phase); }
  FlightPhase phase() const noexcept { return phase_.load(); }
  bool started() const noexcept { return started_.load(); }
  bool to_land() const noexcept { return land_.load(); }  ///< an emergency is one
  bool is_emergency() const noexcept { return emergency_.load(); }

 private:
  std::atomic<FlightPhase> phase_{FlightPhase::checking};
  std::atomic<bool> started_{false}, land_{false}, emergency_{false};
};

}  // namespace sightline::dds
