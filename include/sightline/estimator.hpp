/// Pose filters of robots without a position sensor: measurements, options, broadcast poses, who localizes whom.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/model.hpp"

namespace sightline {

// Inputs of a robot's pose estimator: its motion and its measurements.

/// Motion of a robot as its autopilot reports it: means over [t, t + dt], known at t + dt.
///
/// V is the vehicle frame: G rotated by the heading only. B is the body, R_VB = turn_y(pitch)
/// turn_x(roll).
struct MotionSample {
  double t = 0.0, dt = 0.01;        ///< [s], dt > 0
  Vec3<double> v_V{};               ///< velocity forward, left, up [m/s]
  double yaw_rate = 0.0;            ///< [rad/s]
  double roll = 0.0, pitch = 0.0;   ///< at t [rad]
  Vec3<double> gyro{};              ///< angular velocity in B [rad/s]; only the attitude filter uses it
  Vec3<double> force{};             ///< specific force in B, (0, 0, g) at rest [m/s^2]; likewise
  std::optional<double> compass{};  ///< heading at t [rad], if a compass reported one
};

/// Measured quantity.
enum class Measures {
  sighting,  ///< another body with known pose, observed by the robot's own sensor
  position,  ///< the robot's own position, for example by motion capture or GNSS
  heading,   ///< the robot's own heading, for example by a compass
};

/// Time behaviour of the error of another body's broadcast pose, from message to message.
enum class OtherError {
  fresh,    ///< independent in each message, as from motion capture
  lasting,  ///< slowly varying, as of a localized robot: Gauss-Markov process (ChainFilter)
  unknown,  ///< may depend on the own error: covariance intersection
};

/// A measurement at the time `stamp`; may arrive late and out of order.
struct Measurement {
  Measures of = Measures::sighting;
  double stamp = 0.0;  ///< of the exposure [s]
  int source =
      0;  ///< source number; orders equal stamps, lower first; a source has one measurement per stamp
  Vec3<double> z{};      ///< sighting: the other body in the sensor frame S; position: the robot in G [m]
  Mat<3, 3> R{};         ///< covariance of z, in the same frame [m^2]
  bool has_yaw = false;  ///< of a sighting; a heading always has it
  double yaw = 0.0;      ///< sighting: other body's heading minus the robot's; heading: the robot's [rad]
  double yaw_variance = 1.0;  ///< [rad^2]
  Vec3<double> R_yaw{};       ///< covariance of z and yaw [m rad]
  Vec3<double> p_other{};     ///< of the observed body at the stamp, as broadcast [m]
  double psi_other = 0.0;     ///< its heading [rad]
  Mat<4, 4> P_other{};        ///< covariance of (p_other, psi_other)
  OtherError other_error = OtherError::fresh;

  bool measures_position() const noexcept { return of != Measures::heading; }
  bool measures_heading() const noexcept {
    return of == Measures::heading || (of == Measures::sighting && has_yaw);
  }
  /// The robot's heading that the measurement implies [rad]; requires measures_heading().
  double heading() const noexcept { return of == Measures::heading ? yaw : psi_other - yaw; }
  double heading_variance() const noexcept {
    return of == Measures::heading ? yaw_variance : yaw_variance + P_other(3, 3);
  }
  /// True if its numbers are finite and its variances positive; an unusable measurement is
  /// discarded.
  bool is_usable() const noexcept;
};

/// Measurement::source of a compass; a sighting has the index of a body.
inline constexpr int compass_source = -1;

/// Approximate bounds on a robot's acceleration [m/s^2] and angular acceleration [rad/s^2] while
/// its motion is not measured.
inline constexpr double unmeasured_acceleration = 1.0, unmeasured_turning = 1.0;

inline bool is_finite(const Vec3<double>& v) noexcept {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline bool Measurement::is_usable() const noexcept {
  if (!std::isfinite(stamp)) return false;
  if (measures_heading() && !(std::isfinite(yaw) && yaw_variance > 0 && std::isfinite(yaw_variance)))
    return false;
  if (!measures_position()) return true;
  if (!(is_finite(z) && Cholesky<3>(R).positive)) return false;
  if (of == Measures::position) return true;
  bool usable = is_finite(p_other) && std::isfinite(psi_other) && is_finite(R_yaw);
  for (int i = 0; i < 4; ++i) {
    usable = usable && P_other(i, i) >= 0;
    for (int j = 0; j < 4; ++j) usable = usable && std::isfinite(P_other(i, j));
  }
  return usable;
}

inline bool is_usable(const MotionSample& u) noexcept {
  return std::isfinite(u.t) && u.dt > 0 && std::isfinite(u.dt) && is_finite(u.v_V) &&
         std::isfinite(u.yaw_rate) && std::isfinite(u.roll) && std::isfinite(u.pitch) && is_finite(u.gyro) &&
         is_finite(u.force) && std::isfinite(u.compass.value_or(0.0));
}

// Pose of a body that broadcasts it by radio, at any time between its messages and shortly after.

/// A broadcast: pose, velocity, yaw rate and pose covariance of a body.
struct BroadcastPose {
  double stamp = 0.0;     ///< [s]
  Vec3<double> p{}, v{};  ///< in G [m], [m/s]
  double psi = 0.0;       ///< heading [rad]
  double yaw_rate = 0.0;  ///< [rad/s]
  Mat<4, 4> P{};          ///< covariance of (p, psi)
};

/// Pose of an observed body, with its covariance, as reference of a sighting.
struct KnownPose {
  Vec3<double> p{};
  double psi = 0.0;
  Mat<4, 4> P{};
};

struct BroadcastOptions {
  static constexpr std::string_view name = "broadcast";

  double acceleration = 1.0;
  double velocity_sigma = 0.03;
  double turning = 0.5;
  double longest = 0.3;
  double sighting_rate = 30.0;
  double correlation_time = 0.0;

  static constexpr auto parameters() {
    using O = BroadcastOptions;
    return Parameters{parameter("acceleration", &O::acceleration, "m/s^2", from_zero,
                                "of the body after its last message, standard deviation"),
                      parameter("velocity_sigma", &O::velocity_sigma, "m/s", from_zero,
                                "of the broadcast velocity, each axis"),
                      parameter("turning", &O::turning, "rad/s", from_zero,
                                "of its heading after its last message, besides the broadcast yaw rate"),
                      parameter("longest", &O::longest, "s", above_zero,
                                "after its last message that its pose is carried on"),
                      parameter("sighting_rate", &O::sighting_rate, "Hz", above_zero,
                                "of the sightings that are held against it"),
                      parameter("correlation_time", &O::correlation_time, "s", from_zero,
                                "of the errors of a body's messages; 0: white")};
  }

  bool operator==(const BroadcastOptions&) const = default;
  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
};

/// Between two messages the position is a cubic in time through their positions and velocities
/// (Hermite), and the heading is linear. After the last message the pose is extrapolated, and its
/// uncertainty grows by the options.
///
/// Several sightings between two messages share the error of the messages; a filter would take it
/// to be independent each time. So the covariance is multiplied by the number of sightings per
/// message, if that is above 1.
class BroadcastTrack {
 public:
  static constexpr std::size_t memory = 64;

  /// @throws std::invalid_argument from BroadcastOptions::check()
  explicit BroadcastTrack(const BroadcastOptions& options = {});

  /// Messages may be late and out of order. A message is ignored if it is not finite or has the
  /// stamp of a stored message.
  void take(const BroadcastPose& message) noexcept;
  bool is_known() const noexcept { return count_ > 0; }
  /// Newest message; requires is_known().
  const BroadcastPose& newest() const noexcept { return messages_[count_ - 1]; }
  /// Pose at time t [s]; empty before the first message or too long after the last one.
  std::optional<KnownPose> at(double t) const noexcept;
  void forget() noexcept { count_ = 0; }

 private:
  KnownPose between(const BroadcastPose& a, const BroadcastPose& b, double t) const noexcept;
  KnownPose after(const BroadcastPose& a, double t) const noexcept;
  double uses(double interval) const noexcept;

  BroadcastOptions options_;
  std::array<BroadcastPose, memory> messages_{};  // the first count_ are valid, sorted by stamp
  std::size_t count_ = 0;
};

// Which robot localizes itself by which other robots.

/// A robot and the robots that it observes.
struct Localized {
  std::string name;
  bool is_anchor = false;       ///< its pose is known otherwise, for example by motion capture
  std::vector<int> observes{};  ///< numbers of the robots that may localize it; ignored for an anchor
};

/// Treatment of robots that localize each other in a cycle.
enum class Cycles {
  refused,
  intersected,  ///< covariance intersection within a cycle: consistent, but far less accurate
};

/// Robots in tiers. An anchor has tier 0; any other robot is localized only by robots of lower
/// tiers. So information flows in one direction and is never counted twice.
class LocalizationGraph {
 public:
  /// @throws std::invalid_argument with the robots' names: for a robot without a path to an anchor,
  ///   for a robot that observes itself or a number without a robot, and for a refused cycle
  explicit LocalizationGraph(std::vector<Localized> robots, Cycles cycles = Cycles::refused);

  int robots() const noexcept { return static_cast<int>(robots_.size()); }
  const Localized& robot(int i) const noexcept { return robots_[static_cast<std::size_t>(i)]; }
  /// Robots of one cycle have the same tier.
  int tier(int robot) const noexcept { return tier_[static_cast<std::size_t>(robot)]; }
  /// All robots, lower tiers first.
  const std::vector<int>& order() const noexcept { return order_; }
  /// True if the observer is localized by its sightings of the target.
  bool uses(int observer, int target) const noexcept;
  /// Time behaviour of the error of the target's pose, for that observer.
  OtherError error_of(int observer, int target) const noexcept;

 private:
  std::vector<Localized> robots_;
  std::vector<int> tier_, circle_;  // robots with equal circle_ reach each other
  std::vector<int> order_;
};

// Noise assumptions and options of the pose filters.

/// Step over dt [s] of a Gauss-Markov process with the standard deviation sigma and the correlation
/// time T [s], exact for any dt:
///
///   x(t + dt) = keep x(t) + sigma fresh w,   keep = e^{-dt/T},   fresh = sqrt(1 - keep^2),
///
/// w standard normal. T = 0 is white noise.
struct MarkovStep {
  double keep, fresh;

  MarkovStep(double dt, double time) noexcept
      : keep(time > 0 ? exp(-dt / time) : 0.0), fresh(sqrt(1 - keep * keep)) {}
};

enum class FilterKind {
  heading,   ///< position and heading; roll and pitch are inputs (HeadingFilter)
  attitude,  ///< position, velocity and attitude from an inertial measurement unit (AttitudeFilter)
  chain,     ///< `heading` for a robot that observes a robot which is itself localized (ChainFilter)
};
inline constexpr std::array<std::string_view, 3> filter_kinds = {"heading", "attitude", "chain"};

/// Standard deviations of the motion that a robot's autopilot reports. White noise is that of a
/// mean over 10 ms (`white_period`); over dt it is smaller by sqrt(0.01 s / dt). A bias is a
/// Gauss-Markov process with this standard deviation and correlation time, or a random walk that
/// starts with it.
struct FilterOptions {
  static constexpr std::string_view name = "estimate";
  static constexpr double white_period = 0.01;  // [s]
  static constexpr double compass_rate = 10.0;  // [Hz]

  FilterKind filter = FilterKind::heading;
  double velocity_noise = 0.05;
  double velocity_bias = 0.08;
  double velocity_bias_time = 15.0;
  double yaw_rate_noise = 0.01;
  double yaw_rate_bias = 0.02;
  double yaw_rate_walk = 2e-4;
  double tilt_noise = 0.003;
  double tilt_bias = 0.012;
  double tilt_time = 10.0;
  double gyro_noise = 0.005;
  double gyro_bias = 0.02;
  double gyro_walk = 2e-4;
  double accelerometer_noise = 0.08;
  double accelerometer_bias = 0.1;
  double accelerometer_walk = 2e-3;
  double compass_noise = 0.0;
  double compass_time = 0.0;
  double correlation_time = 0.0;
  double camera_turn = 0.0;
  double other_error_time = 2.0;
  double other_error_spread = 1.0;
  int start_sightings = 3;
  int restart_sightings = 8;

  static constexpr auto parameters() {
    using O = FilterOptions;
    constexpr Bounds count = {1, 32, "1 to 32"};
    return Parameters{
        parameter("filter", &O::filter, filter_kinds,
                  "position and heading, or the whole attitude by an inertial measurement unit"),
        parameter("velocity_noise", &O::velocity_noise, "m/s", above_zero,
                  "white noise of the measured velocity, each axis, mean over 10 ms"),
        parameter("velocity_bias", &O::velocity_bias, "m/s", from_zero, "its bias, each axis"),
        parameter("velocity_bias_time", &O::velocity_bias_time, "s", above_zero,
                  "correlation time of that bias"),
        parameter("yaw_rate_noise", &O::yaw_rate_noise, "rad/s", above_zero,
                  "white noise of the yaw rate, mean over 10 ms; heading filter"),
        parameter("yaw_rate_bias", &O::yaw_rate_bias, "rad/s", from_zero, "its bias at the start"),
        parameter("yaw_rate_walk", &O::yaw_rate_walk, "rad/s/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("tilt_noise", &O::tilt_noise, "rad", from_zero,
                  "white noise of roll and pitch; heading filter"),
        parameter("tilt_bias", &O::tilt_bias, "rad", from_zero, "slow error of roll and pitch"),
        parameter("tilt_time", &O::tilt_time, "s", above_zero, "correlation time of that error"),
        parameter("gyro_noise", &O::gyro_noise, "rad/s", above_zero,
                  "white noise of the gyroscope, each axis, mean over 10 ms; attitude filter"),
        parameter("gyro_bias", &O::gyro_bias, "rad/s", from_zero, "its bias at the start"),
        parameter("gyro_walk", &O::gyro_walk, "rad/s/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("accelerometer_noise", &O::accelerometer_noise, "m/s^2", above_zero,
                  "white noise of the accelerometer, each axis, mean over 10 ms; attitude filter"),
        parameter("accelerometer_bias", &O::accelerometer_bias, "m/s^2", from_zero, "its bias at the start"),
        parameter("accelerometer_walk", &O::accelerometer_walk, "m/s^2/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("compass_noise", &O::compass_noise, "rad", from_zero,
                  "white noise of the heading by a compass, 10 times a second; 0: it has none"),
        parameter("compass_time", &O::compass_time, "s", from_zero,
                  "correlation time of its error; 0: white"),
        parameter("correlation_time", &O::correlation_time, "s", from_zero,
                  "of the errors of sightings; 0: white; by default that of the camera"),
        parameter("camera_turn", &O::camera_turn, "rad", from_zero,
                  "turn of the camera against its mount, each axis, that is estimated; 0: it is known; "
                  "attitude filter"),
        parameter("other_error_time", &O::other_error_time, "s", above_zero,
                  "correlation time of the error of a body that is localized itself; chain filter"),
        parameter("other_error_spread", &O::other_error_spread, "", {1, 100, "1 to 100"},
                  "factor by which that time may be off, either way; chain filter"),
        parameter("start_sightings", &O::start_sightings, "", count,
                  "sightings that must mean the same place before there is an estimate"),
        parameter(
            "restart_sightings", &O::restart_sightings, "", count,
            "refused sightings that mean the same place, without an accepted one between, after which the "
            "filter begins anew")};
  }

  bool operator==(const FilterOptions&) const = default;

  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
};

// Interface of the filters for a robot's pose.

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

/// Most bodies of whose sightings one filter estimates the correlated errors, its compass counted as one.
inline constexpr int correlated_sources_max = 4;

/// @param mount     mount of the sensor of the sightings
/// @param observed  number of bodies that the robot observes
/// @throws std::invalid_argument from FilterOptions::check(), and for more than
///   correlated_sources_max bodies and compasses whose errors are correlated
std::unique_ptr<PoseFilter> make_pose_filter(const FilterOptions& options, const SensorMount& mount,
                                             int observed = 1);

// Robot position that one measurement implies.

/// Rotation R_VB.
inline Mat<3, 3> tilt(double roll, double pitch) noexcept { return turn_y(pitch) * turn_x(roll); }

/// Roll and pitch at a time t [s] within a sample or shortly after it, extrapolated to first order
/// with the gyroscope.
inline Vec2<double> tilt_at(const MotionSample& u, double t) noexcept {
  const SinCos<double> roll = sincos(u.roll), pitch = sincos(u.pitch);
  const double d = t - u.t, across = u.gyro.y * roll.sin + u.gyro.z * roll.cos;
  return {u.roll + d * (u.gyro.x + across * pitch.sin / pitch.cos),
          u.pitch + d * (u.gyro.y * roll.cos - u.gyro.z * roll.sin)};
}

/// Position that a measurement implies for a given heading.
struct Place {
  Vec3<double> p;         ///< in G [m]
  Mat<3, 3> P;            ///< its covariance, including the heading's variance [m^2]
  Vec3<double> per_turn;  ///< d p / d psi [m]
};

/// @param tilt_variance  of the reported roll and pitch [rad^2]; not used if a gimbal levels the
///   sensor
inline Place place_of(const Measurement& z, const SensorMount& mount, const Vec2<double>& roll_pitch,
                      double psi, double psi_variance, double tilt_variance) noexcept {
  if (z.of == Measures::position) return {z.z, z.R, {}};
  const bool leans = mount.frame == MountFrame::body;
  const Mat<3, 3> R_VB = leans ? tilt(roll_pitch.x, roll_pitch.y) : identity<3>();
  const Mat<3, 3> R_GB = turn_z(psi) * R_VB, R_GS = R_GB * mount.attitude();
  const Vec3<double> r = R_GB * mount.offset + R_GS * z.z;
  Place place;
  place.p = z.p_other - r;
  place.per_turn = {r.y, -r.x, 0.0};
  place.P = R_GS * z.R * transposed(R_GS) + block<3, 3>(z.P_other, 0, 0) +
            psi_variance * outer(place.per_turn, place.per_turn);
  if (leans) {
    const Mat<3, 3> K = cross_matrix(r);
    place.P += tilt_variance * (K * transposed(K));
  }
  return place;
}

}  // namespace sightline
