/// The log of a run: a thread that writes the ring's samples to disk.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "sightline/base/service_thread.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/record/mcap.hpp"
#include "sightline/run/loop.hpp"

namespace sightline {

/// Writes into the folder of a run
///
///   run.mcap      what depends on simulated time alone, so that equal runs give equal bytes; log time is the
///                 simulated time from 0 [ns]. Topics:
///                   /BODY/state                {time, x}: all numbers, exactly
///                   /BODY/pose, /BODY/twist    of the true state, in G
///                   /BODY/measured             the pose the controllers saw, where noise or delay change it
///                   /AGENT/attitude            the true one, of vehicles; by the model of other robots with a camera
///                                              that is fixed to the body
///                   /AGENT/camera_info         sensor_msgs/CameraInfo of a camera, once
///                   /AGENT/input               {time, u, raw}: applied, and before the solver's clamp
///                   /AGENT/path                the prediction, where the sample has one
///                   /AGENT/reference           {time, p, d}, each 0.1 s; without p or d where that is free
///                   /AGENT/barrier             {time, active, conflict, reserve}, where there is a barrier
///                   /solver                    {time, status, residual, iterations, cost}; of several
///                                              controllers /controller0/solver, ...; with pairs where robots
///                                              are kept apart
///                   /events                    {time, kind, controller, value}
///                   /tuned                     {time, number, name, text}, of a flight that is tuned
///                 what a replay needs, as recorded_flight.hpp says; and words: "sightline" with scenario, version,
///                 compiler, seed, solver and team, "files" with the texts of the files that the scenario names.
///                 Beside those of the periods there are states, poses and twists of periods that were missed, where the
///                 world knows the truth, and at the end those after the last command.
///   timing.csv    measured times [us], allocations and missed periods; a row for each period
///
/// In JSON, null is a number that was not finite; ROS messages with such numbers are left out.
///
/// Each 0.1 s of simulated time a chunk closes and is handed to the kernel with the rows of timing.csv, so a
/// killed run leaves all chunks before. Where the disk fails, or a sample cannot be written or judged, the ring is
/// still drained: the loop goes on, and error() tells what is lost.
class Log {
 public:
  /// Makes the folder if need be and opens the files beside those of an earlier run. With the first sample they take their
  /// place, and the earlier results go; without one, what stood there stays.
  /// @param ring     outlives the log
  /// @param written  called by the thread with the simulated time [s] up to which all is on its way to the
  ///                 disk; not after a failure, nor after it threw
  /// @param flown    how it was flown, beside what the scenario says; stands with the words "sightline"
  Log(const Scenario& scenario, const std::filesystem::path& folder, const Controllers& controllers,
      SpscQueue<Sample>& ring, std::function<void(double)> written = {}, const McapWords& flown = {});
  ~Log();  ///< As finish(), once the ring is closed, which it is here for a loop that never ran.
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  /// Starts the thread.
  void start();
  /// Waits until the ring is closed and drained, and ends the files.
  void finish();

  /// After finish(): the first failure, a sentence; empty if all was written and judged.
  std::string error() const;
  /// After finish(): whether the folder holds this log, and not what was there before.
  bool begun() const;
  /// After finish(): of all samples that could be judged, written or not.
  const Summary& summary() const;

 private:
  class Files;

  SpscQueue<Sample>& ring_;
  std::unique_ptr<Files> files_;
  ServiceThread thread_{"the log"};
};

}  // namespace sightline
