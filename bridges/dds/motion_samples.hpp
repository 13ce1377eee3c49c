/// What an estimator is told of a robot's motion, from the odometry of the robot.
#pragma once

#include <optional>

#include "bridges/dds/pose_subscriber.hpp"
#include "sightline/estimate/measurement.hpp"

namespace sightline::dds {

/// Of one robot; one thread, allocates nothing. A sample lasts from one message to the next. Its velocity in V is the mean of both, its yaw
/// rate what the heading turned by. Neither the place nor the heading of the odometry's frame enters.
///
/// A turn that the rate of the heading does not explain is a correction of the autopilot's estimator: the rate counts then. After a gap
/// the sample is as short as the ones before, and the filter knows how long nothing was told.
class MotionSamples {
 public:
  static constexpr double shortest = 1e-3, longest = 0.1;  ///< between two messages [s]
  static constexpr double unexplained = 0.2;               ///< [rad]

  /// @param seen    in the order in which they came; one that is not newer than the last says nothing
  /// @param origin  time 0 of the samples, of the monotonic clock
  std::optional<MotionSample> take(const SeenMotion& seen, Nanoseconds origin) noexcept;

 private:
  bool begun_ = false;
  SeenMotion last_{};
};

}  // namespace sightline::dds
