/// Tuning of a flight by watchers: requests over the page's WebSocket, and their answers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "sightline/scenario.hpp"
#include "sightline/server/paced_clock.hpp"
#include "sightline/server/page_server.hpp"

namespace sightline {

/// Controls of the flight besides changes of the team.
struct TuningControls {
  PacedClock* clock = nullptr;  ///< clock that can be paused; null: the flight cannot be paused
  /// Ends this flight and starts another one with that seed; none: not possible.
  std::function<void(std::uint64_t seed)> restart{};
};

/// Handles the messages of watchers. A message is one JSON object with one of event, pause, step,
/// seed:
///
///   {"id": "7", "event": {"retune": {"couple": "view", "weight": 0.4}}, "ramp": 0.5}
///   {"id": "8", "pause": true}     {"id": "9", "step": 1}     {"id": "10", "seed": 7}
///
/// tuner.hpp lists the events; ramp is optional. All watchers receive the latest answers with each
/// state: "answers": [[number, id, accepted, sentence]]. The answer to a refused change has the
/// reason, as `sightline check` prints it.
///
/// A thread parses the messages and produces the events (TunedScript), so that neither the loop nor
/// the server waits. Messages are discarded while `waiting_max` wait.
class Tuning {
 public:
  static constexpr std::size_t waiting_max = 64;
  static constexpr std::size_t answers_reported = 32;  ///< with each state
  static constexpr std::size_t id_size_max = 64;
  static constexpr int steps_max = 1000;  ///< per message

  /// @param scenario  must have `tuned`
  /// @throws std::invalid_argument as Tuner
  Tuning(const Scenario& scenario, TuningControls controls);
  ~Tuning();
  Tuning(const Tuning&) = delete;
  Tuning& operator=(const Tuning&) = delete;

  /// Queues a message of a watcher. For any thread.
  void receive(std::string_view message);
  /// Time of the flight [s]. For any thread.
  void set_time(double t) noexcept;
  /// Refuses all later requests except a seed. For any thread.
  void end() noexcept;

  /// Increases with each new answer or file. For any thread.
  std::uint64_t version() const noexcept;
  /// Suffix of a state's JSON object: `,"answers":[...],"paused":false`.
  std::string reported() const;
  /// /tune.json, the tunable values; /tuned.toml and /final.toml, the tuned scenarios (tuner.hpp).
  PageFiles files() const;
  /// Messages that were refused, and messages that were discarded.
  std::int64_t refused() const noexcept;
  std::int64_t stale() const noexcept;

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sightline
