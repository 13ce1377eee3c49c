/// Log of a run: a thread that writes the samples of a queue to disk.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "sightline/base.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/log.hpp"
#include "sightline/loop.hpp"

namespace sightline {

/// Writes into the folder of a run
///
///   run.mcap      only data that depends on simulated time, so equal runs give equal bytes; log
///                 time is the simulated time from 0 [ns]. Topics:
///                   /BODY/state                {time, x}: all numbers, exact
///                   /BODY/pose, /BODY/twist    of the true state, in G
///                   /BODY/measured             the pose that the controllers receive, if noise or
///                                              delay change it
///                   /AGENT/attitude            true attitude of vehicles, or as links receive it; from the
///                                              model for other robots with a body-fixed camera
///                   /AGENT/camera_info         sensor_msgs/CameraInfo of the first camera, once
///                   /AGENT/SENSOR/camera_info  of each further one
///                   /AGENT/input               {time, u, raw}: applied, and before the solver's
///                                              clamp
///                   /AGENT/path                the prediction, if the sample has one
///                   /AGENT/reference           {time, p, d}, each 0.1 s; without p or d if free
///                   /AGENT/barrier             {time, active, conflict, reserve}, with a barrier
///                   /solver                    {time, status, residual, iterations, cost}; with
///                                              several controllers /controller0/solver, ...; with
///                                              pairs if robots are kept apart
///                   /events                    {time, kind, controller, value}
///                   /tuned                     {time, number, name, text}, of a tuned flight
///                 the inputs of a replay, see RecordedFlight in log.hpp; and metadata: "sightline" with
///                 scenario, version, compiler, seed, solver and team; "files" with the texts of
///                 the files that the scenario names.
///                 States, poses and twists also cover missed periods, if the world knows the
///                 truth, and the time after the last command.
///   timing.csv    measured times [us], allocations and missed periods; one row for each period
///
/// In JSON, null is a number that was not finite; ROS messages with such numbers are omitted.
///
/// Each 0.1 s of simulated time a chunk closes and goes to the kernel with the rows of timing.csv;
/// so a killed run keeps all earlier chunks. If the disk fails, or a sample cannot be written or
/// judged, the thread still drains the queue. The loop continues, and error() reports the loss.
class Log {
 public:
  /// Creates the folder if necessary and opens new files beside those of an earlier run. With the
  /// first sample the new files replace the old ones, and the earlier results are removed. Without
  /// a sample the earlier files stay.
  /// @param ring     queue of samples; must outlive the log
  /// @param written  called by the log's thread with the simulated time [s] up to which all data
  ///   was passed to the kernel; not called after a failure, nor after it has thrown
  /// @param flown    how the scenario is flown, beyond its text; stored in the metadata "sightline"
  Log(const Scenario& scenario, const std::filesystem::path& folder, const Controllers& controllers,
      SpscQueue<Sample>& ring, std::function<void(double)> written = {}, const McapWords& flown = {});
  ~Log();  ///< Same as finish(), after the queue is closed; closes it itself if the loop never ran.
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  /// Starts the thread.
  void start();
  /// Waits until the queue is closed and drained, then completes the files.
  void finish();

  /// After finish(): the first failure as a sentence; empty if all was written and judged.
  std::string error() const;
  /// After finish(): true if the folder contains this log, not the earlier files.
  bool begun() const;
  /// After finish(): summary of all samples that could be judged, written or not.
  const Summary& summary() const;

 private:
  class Files;

  SpscQueue<Sample>& ring_;
  std::unique_ptr<Files> files_;
  ServiceThread thread_{"the log"};
};

}  // namespace sightline
