/// Inputs of a robot's pose estimator: its motion and its measurements.
#pragma once

#include <cmath>
#include <optional>

#include "sightline/base/matrix.hpp"

namespace sightline {

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

}  // namespace sightline
