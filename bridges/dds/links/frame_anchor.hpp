/// Keeps a robot's odometry frame fixed across estimator jumps that the robot reports.
#pragma once

#include <atomic>

#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

/// A reported jump moves the odometry frame, not the robot. The pose continues from the last one,
/// extrapolated by its velocity, so distances to other robots stay valid.
/// The accumulated frame displacement bounds how long this can be trusted. Headings pass unchanged:
/// velocities are commanded in the frame, not in the body.
class FrameAnchor {
 public:
  /// Begins to compensate. Earlier jumps are those of the estimator's initialisation and pass. Any
  /// thread may call it.
  void hold() noexcept { held_ = true; }

  /// Transforms a finite motion into the original frame; motions come in order. Receive thread only;
  /// allocates nothing.
  /// @param resets   jumps so far, as the robot counts them
  /// @param sampled  by a clock that does not jump
  void follow(Motion& local, int resets, Nanoseconds sampled) noexcept;

  /// Accumulated length of all jumps [m]. Any thread may call it.
  double moved() const noexcept { return moved_; }
  int jumps() const noexcept { return jumps_; }

 private:
  std::atomic<bool> held_{false};
  std::atomic<double> moved_{0.0};
  std::atomic<int> jumps_{0};
  // Receive thread only.
  bool begun_ = false;
  int resets_ = 0;
  Nanoseconds sampled_ = 0;
  Motion last_{};  // in the original frame
  Vec3<double> shift_{};
};

}  // namespace sightline::dds
