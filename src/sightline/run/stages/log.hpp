/// Stage "log": the samples of the loop, from the sink and back to it.
#pragma once

#include "sightline/loop.hpp"
#include "sightline/run/stages/period.hpp"

namespace sightline::stages {

class Log {
 public:
  /// @param size  a sample of the loop's size, written if the sink is full
  /// @throws std::invalid_argument unless the sink's items are of this size
  Log(Sink<Sample>& sink, const Clock& clock, const LoopOptions& options, const Sample& size, Period& period);

  /// Begins the sample of a period. In simulated time it waits for room, but neither for an
  /// abandoned sink nor after a stop request. The flight does not depend on the recorder.
  void open(Period& period) noexcept;
  /// Publishes the sample with the events.
  void run(Period& period) noexcept;
  /// Publishes true states between two updates, if there is room.
  void show(const Period& period, double t, std::span<const double> truth) noexcept;
  /// Publishes the states after the last command, true or else measured, with the events that are
  /// in no sample yet.
  void show_end(Period& period, World& world) noexcept;

 private:
  using Claim = Sample* (Sink<Sample>::*)() noexcept;
  /// In simulated time waits for room: log_patience, `after_stop` [s] after a stop request, and not
  /// for an abandoned sink. nullptr: no room.
  Sample* wait_for(Claim claim, double after_stop) noexcept;
  void fill(const Period& period, double t, std::span<const double> x, bool is_truth,
            Sample& sample) const noexcept;

  Sink<Sample>& sink_;
  const Clock& clock_;
  const LoopOptions& options_;
  std::int64_t path_every_, next_path_;  // [periods]
  std::int64_t reported_ = 0;            // dropped samples, as last reported
  Sample spare_;
  bool is_stuck_ = false;  // no room in the sink for log_patience
};

}  // namespace sightline::stages
