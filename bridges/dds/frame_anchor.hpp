/// Keeps the frame of a robot's odometry where it was, when its estimator says that it jumped.
#pragma once

#include <atomic>

#include "bridges/dds/conversion.hpp"

namespace sightline::dds {

/// A jump that the estimator counts is none of the robot: its frame moved. The pose goes on where it was, moved on by its velocity, and
/// so distances to others stay what they were known to be; how far the frame moved in sum says how long that can be
/// trusted. A heading is believed as it comes, since velocities are asked for in the frame and not in the body.
class FrameAnchor {
 public:
  /// From now on; what moves before is the estimator that finds its place. Of any thread.
  void hold() noexcept { held_ = true; }

  /// Puts a motion into the frame as it was. Of the thread that receives; allocates nothing.
  /// @param resets   jumps so far, as the robot counts them
  /// @param sampled  by its clock
  /// @return false for one that is not finite, or not newer than the last by a clock that runs on: it says nothing
  bool follow(Motion& local, int resets, Nanoseconds sampled) noexcept;

  /// All jumps in sum [m]. Of any thread.
  double moved() const noexcept { return moved_; }
  int jumps() const noexcept { return jumps_; }

 private:
  std::atomic<bool> held_{false};
  std::atomic<double> moved_{0.0};
  std::atomic<int> jumps_{0};
  // Of the thread that receives.
  bool begun_ = false;
  int resets_ = 0;
  Nanoseconds sampled_ = 0;
  Motion last_{};  // in the frame as it was
  Vec3<double> shift_{};
};

}  // namespace sightline::dds
