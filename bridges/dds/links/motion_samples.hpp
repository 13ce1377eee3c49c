/// Motion inputs of the pose estimator from a robot's odometry.
#pragma once

#include <optional>

#include "bridges/dds/topics/pose_subscriber.hpp"
#include "sightline/estimator.hpp"

namespace sightline::dds {

/// Samples of one robot; single thread, allocates nothing. A sample spans two consecutive messages.
/// Its velocity in V is the mean of both, its yaw rate the heading change per time. Position and
/// heading of the odometry frame have no influence.
///
/// If the heading rate does not explain the heading change, the autopilot's estimator corrected its
/// heading; the reported rate then applies.
/// After a gap the sample has the default length, so the filter also receives the duration without
/// data.
class MotionSamples {
 public:
  static constexpr double shortest = 1e-3, longest = 0.1;  ///< between two messages [s]
  static constexpr double unexplained = 0.2;               ///< heading change [rad]

  /// @param seen    in order of arrival; one that is not newer than the last gives no sample
  /// @param origin  time 0 of the samples, of the monotonic clock
  std::optional<MotionSample> take(const SeenMotion& seen, Nanoseconds origin) noexcept;

 private:
  bool begun_ = false;
  SeenMotion last_{};
};

}  // namespace sightline::dds
