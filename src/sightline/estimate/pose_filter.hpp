/// Interface of the filters for a robot's pose.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "sightline/estimate/broadcast_track.hpp"
#include "sightline/estimate/filter_options.hpp"
#include "sightline/estimate/measurement.hpp"
#include "sightline/model/frames.hpp"

namespace sightline {

/// Estimated pose and velocity of a robot, with their uncertainty.
struct PoseEstimate {
  bool known = false;     ///< false: the other members are undefined
  double stamp = 0.0;     ///< [s]
  Vec3<double> p{}, v{};  ///< in G [m], [m/s]
  double psi = 0.0;       ///< heading [rad], in [-pi, pi]
  double yaw_rate = 0.0;  ///< [rad/s]
  Mat<4, 4> P{};          ///< covariance of (p, psi)
  double velocity_sigma = 0.0,
         yaw_rate_sigma = 0.0;  ///< of v, root of the sum over its axes [m/s]; of yaw_rate [rad/s]
  double last_accepted = 0.0;   ///< stamp of the last accepted measurement [s]

  /// Root of the sum of the variances of p [m].
  double position_sigma() const noexcept { return sqrt(P(0, 0) + P(1, 1) + P(2, 2)); }
  double heading_sigma() const noexcept { return sqrt(P(3, 3)); }  ///< [rad]
  /// Standard deviation of the direction to another body in V [rad]; the errors of the two poses
  /// must be independent.
  double bearing_sigma(const KnownPose& other) const noexcept;
};

/// Result of a measurement.
enum class FitVerdict : std::uint8_t {
  accepted,
  accepted_position,  ///< position only; the yaw contradicts
  rejected,           ///< beyond the gate
  started,            ///< the estimate starts from this measurement
  restarted,          ///< too many contradictions: the estimate restarts from this measurement
  waiting,            ///< no estimate yet: stored as a candidate for agreement
  pending,            ///< later than the motion samples; applied with the sample that contains it
  too_old,            ///< earlier than the memory or the start of the estimate
  repeated,           ///< same source and stamp as an earlier measurement
  unusable,           ///< not finite, variance not positive, too far ahead, or too many are pending
};
inline constexpr int verdict_count = 10;
std::string_view to_string(FitVerdict verdict);

/// Fit of a measurement to the estimate.
struct Fit {
  FitVerdict verdict = FitVerdict::waiting;
  int dimension = 0;          ///< of the innovation that was gated; 0: none
  double squared = 0.0;       ///< y^T S^-1 y, chi^2 distributed with `dimension` degrees of freedom
  std::array<double, 4> y{};  ///< innovation: position [m] (in V or B), then heading [rad]
};

/// Error-state Kalman filter for measurements out of sequence.
///
/// A measurement is applied at its stamp, and all later motion and measurements are applied again.
/// So the estimate equals, bit for bit, that of measurements in order, with two exceptions: a
/// measurement older than the memory (64 samples, 64 measurements), and a restart. After
/// construction nothing allocates, throws, locks or prints.
class PoseFilter {
 public:
  static constexpr std::size_t memory = 64;

  virtual ~PoseFilter() = default;

  /// Adds a motion sample. Samples are consecutive. A sample that begins after the end of the
  /// previous one also covers the gap, with the uncertainty of unmeasured motion. A sample is
  /// ignored if it ends before the previous one or is not finite.
  virtual void advance(const MotionSample& motion) noexcept = 0;
  virtual Fit take(const Measurement& measurement) noexcept = 0;
  /// Starts now from a pose that is known otherwise.
  /// @param P  covariance of (p, psi), positive definite
  virtual void start(const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept = 0;
  /// Discards the estimate.
  virtual void forget() noexcept = 0;

  /// Estimate at the end of the last sample.
  virtual PoseEstimate estimate() const noexcept = 0;
};

/// Compass heading of a motion sample; empty without a compass.
std::optional<Measurement> compass_of(const MotionSample& motion, const FilterOptions& options) noexcept;

/// @param mount  mount of the sensor of the sightings
/// @throws std::invalid_argument from FilterOptions::check()
std::unique_ptr<PoseFilter> make_pose_filter(const FilterOptions& options, const SensorMount& mount);

}  // namespace sightline
