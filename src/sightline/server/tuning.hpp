/// A flight that is tuned by those who look on: what they ask for by a page's WebSocket, and what becomes of it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "sightline/scenario/scenario.hpp"
#include "sightline/server/paced_clock.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline {

/// What else than the team can be asked for.
struct TuningControls {
  PacedClock* clock = nullptr;  ///< that can be paused; none: the flight keeps a time of its own
  /// Ends this flight and begins another one with that seed; none: it cannot be.
  std::function<void(std::uint64_t seed)> restart{};
};

/// A message is one JSON object, with one of event, pause, step, seed:
///
///   {"id": "7", "event": {"retune": {"couple": "view", "weight": 0.4}}, "ramp": 0.5}    tuner.hpp says the events; ramp may be left out
///   {"id": "8", "pause": true}     {"id": "9", "step": 1}     {"id": "10", "seed": 7}
///
/// Each is answered to all who look on, with the next states: "answers": [[number, id, accepted, sentence]], the last of them. A change
/// that is refused says why, as `sightline check` does.
///
/// A thread of its own reads them and makes events of them (TunedScript), so that neither the loop nor the server waits. Of messages that
/// come while `waiting_max` wait, none is heard.
class Tuning {
 public:
  static constexpr std::size_t waiting_max = 64;
  static constexpr std::size_t answers_reported = 32;  ///< with each state
  static constexpr std::size_t id_size_max = 64;
  static constexpr int steps_max = 1000;  ///< at once

  /// @param scenario  with `tuned`
  /// @throws std::invalid_argument as Tuner
  Tuning(const Scenario& scenario, TuningControls controls);
  ~Tuning();
  Tuning(const Tuning&) = delete;
  Tuning& operator=(const Tuning&) = delete;

  /// Of any thread.
  void receive(std::string_view message);
  /// Time of the flight [s]. Of any thread.
  void set_time(double t) noexcept;
  /// Nothing is changed any more. Of any thread.
  void end() noexcept;

  /// Another one whenever there is something new to be told. Of any thread.
  std::uint64_t version() const noexcept;
  /// For the end of a state's object: `,"answers":[...],"paused":false`.
  std::string reported() const;
  /// /tune.json, what may be tuned; /tuned.toml and /final.toml, the scenario with what was (tuner.hpp).
  PageFiles files() const;
  /// Messages that were refused, and those that nobody heard.
  std::int64_t refused() const noexcept;
  std::int64_t stale() const noexcept;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
