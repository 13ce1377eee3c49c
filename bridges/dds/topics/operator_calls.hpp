/// Operator requests during a flight and their answers; no messages.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

namespace sightline::dds {

/// Phase of a flight, as reported to the operator.
enum class FlightPhase : std::uint8_t {
  checking,    ///< waits for robots to become ready
  waiting,     ///< all are ready; waits for the operator's start request
  taking_off,  ///< until all hold
  task,
  landing,
  over,
};

struct CallAnswer {
  bool success = false;
  std::string_view message{};
};

/// Any thread may call these; lock-free. A repeated request has no further effect.
class OperatorCalls {
 public:
  CallAnswer start() noexcept;      ///< take off, if that waits for the operator
  CallAnswer stop() noexcept;       ///< end the task: all land
  CallAnswer land() noexcept;       ///< at any time
  CallAnswer emergency() noexcept;  ///< stop the motors of all robots that this program armed

  // Called by the flight.
  void is_at(FlightPhase phase) noexcept { phase_.store(phase); }
  FlightPhase phase() const noexcept { return phase_.load(); }
  bool started() const noexcept { return started_.load(); }
  bool to_land() const noexcept { return land_.load(); }  ///< true in an emergency, too
  bool is_emergency() const noexcept { return emergency_.load(); }

 private:
  std::atomic<FlightPhase> phase_{FlightPhase::checking};
  std::atomic<bool> started_{false}, land_{false}, emergency_{false};
};

}  // namespace sightline::dds
