/// The filter of one robot's pose, whatever it estimates beside it.
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

/// Where a robot is, and how sure that is.
struct PoseEstimate {
  bool known = false;     ///< false: nothing below means anything
  double stamp = 0.0;     ///< [s]
  Vec3<double> p{}, v{};  ///< in G [m], [m/s]
  double psi = 0.0;       ///< heading [rad], in [-pi, pi]
  double yaw_rate = 0.0;  ///< [rad/s]
  Mat<4, 4> P{};          ///< covariance of (p, psi)
  double velocity_sigma = 0.0,
         yaw_rate_sigma = 0.0;  ///< of v, root of the sum over its axes [m/s]; of yaw_rate [rad/s]
  double last_accepted = 0.0;   ///< stamp of the last measurement that was believed [s]

  /// Root of the sum of the variances of p [m].
  double position_sigma() const noexcept { return sqrt(P(0, 0) + P(1, 1) + P(2, 2)); }
  double heading_sigma() const noexcept { return sqrt(P(3, 3)); }  ///< [rad]
  /// Standard deviation of the direction of another body in V, whose error is independent of this one [rad].
  double bearing_sigma(const KnownPose& other) const noexcept;
};

/// What became of a measurement.
enum class FitVerdict : std::uint8_t {
  accepted,
  accepted_position,  ///< its position alone; its yaw contradicts
  rejected,           ///< beyond the gate
  started,            ///< there is an estimate from now on, from it
  restarted,          ///< too many contradicted: the estimate began anew, from it
  waiting,            ///< before there is an estimate: it is remembered, as one of those that must agree
  pending,            ///< it is ahead of the motion samples, and will be taken with the one it falls into
  too_old,            ///< it is from before all that is remembered
  repeated,           ///< the same source and stamp as one before
  unusable,           ///< a number is not finite, or a variance not positive
};
inline constexpr int verdict_count = 10;
std::string_view to_string(FitVerdict verdict);

/// How a measurement fitted.
struct Fit {
  FitVerdict verdict = FitVerdict::waiting;
  int dimension = 0;          ///< of the innovation that was judged; 0: none was
  double squared = 0.0;       ///< y^T S^-1 y: chi^2 of that many degrees of freedom
  std::array<double, 4> y{};  ///< innovation, position [m] (in V or B), then heading [rad]
};

/// Error-state Kalman filter with a memory.
///
/// A measurement is applied at its stamp, and all that came after is applied again: the estimate is the one that
/// it would be had everything arrived in order, bit for bit, as long as no measurement is older than the memory
/// (64 samples, 64 measurements) and none makes it begin anew. Nothing allocates, throws, locks or prints once it
/// is made.
class PoseFilter {
 public:
  static constexpr std::size_t memory = 64;

  virtual ~PoseFilter() = default;

  /// The robot moved so. Samples follow each other; one that begins later than the last ended holds from there
  /// on, with the doubt of a motion that nobody measured. One that ends before the last did, or is not finite, is
  /// ignored.
  virtual void advance(const MotionSample& motion) noexcept = 0;
  virtual Fit take(const Measurement& measurement) noexcept = 0;
  /// Begins now from what is known otherwise.
  /// @param P  covariance of (p, psi), positive definite
  virtual void start(const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept = 0;
  /// There is no estimate any more.
  virtual void forget() noexcept = 0;

  /// At the end of the last sample.
  virtual PoseEstimate estimate() const noexcept = 0;
};

/// The heading that a compass told with a sample; none without a compass.
std::optional<Measurement> compass_of(const MotionSample& motion, const FilterOptions& options) noexcept;

/// @param mount  where the sensor of the sightings sits
/// @throws std::invalid_argument from FilterOptions::check()
std::unique_ptr<PoseFilter> make_pose_filter(const FilterOptions& options, const SensorMount& mount);

}  // namespace sightline
