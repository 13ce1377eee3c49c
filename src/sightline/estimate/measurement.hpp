/// What the estimator of one robot is told: its own motion, and what it measures from time to time.
#pragma once

#include <cmath>
#include <optional>

#include "sightline/base/matrix.hpp"

namespace sightline {

/// What an autopilot tells of a robot's motion, as means over [t, t + dt]; known at t + dt.
///
/// V is the vehicle frame: G turned by the heading alone. B is the body, R_VB = turn_y(pitch) turn_x(roll).
struct MotionSample {
  double t = 0.0, dt = 0.01;        ///< [s], dt > 0
  Vec3<double> v_V{};               ///< velocity ahead, to the left, up [m/s]
  double yaw_rate = 0.0;            ///< [rad/s]
  double roll = 0.0, pitch = 0.0;   ///< at t [rad]
  Vec3<double> gyro{};              ///< angular velocity in B [rad/s]; the attitude filter alone needs it
  Vec3<double> force{};             ///< specific force in B, (0, 0, g) at rest [m/s^2]; likewise
  std::optional<double> compass{};  ///< heading at t [rad], where a compass told one
};

/// What a measurement is of.
enum class Measures {
  sighting,  ///< another body whose pose is known, seen by the robot's own sensor
  position,  ///< the robot's own position, as by motion capture or GNSS
  heading,   ///< its own heading, as by a compass
};

/// How the error of what another body tells of itself goes on from one of its messages to the next.
enum class OtherError {
  fresh,  ///< each message has an error of its own, as from motion capture
  lasting,  ///< it changes slowly, as that of a body that is localized itself: a Gauss-Markov process (ChainFilter)
  unknown,  ///< it may depend on one's own: covariance intersection
};

/// A measurement of the time `stamp`, which may arrive late and out of order.
struct Measurement {
  Measures of = Measures::sighting;
  double stamp = 0.0;  ///< of the exposure [s]
  int source =
      0;  ///< whose it is: of two with one stamp, the lower comes first; one source has one of a stamp
  Vec3<double> z{};      ///< sighting: the other body in the sensor frame S; position: the robot in G [m]
  Mat<3, 3> R{};         ///< covariance of z, in the same frame [m^2]
  bool has_yaw = false;  ///< of a sighting; a heading has it always
  double yaw = 0.0;      ///< sighting: heading of the other body less the robot's; heading: the robot's [rad]
  double yaw_variance = 1.0;  ///< [rad^2]
  Vec3<double> R_yaw{};       ///< covariance of z and yaw [m rad]
  Vec3<double> p_other{};     ///< of the body seen, at the stamp, as it tells [m]
  double psi_other = 0.0;     ///< its heading [rad]
  Mat<4, 4> P_other{};        ///< covariance of (p_other, psi_other)
  OtherError other_error = OtherError::fresh;

  bool measures_position() const noexcept { return of != Measures::heading; }
  bool measures_heading() const noexcept {
    return of == Measures::heading || (of == Measures::sighting && has_yaw);
  }
  /// The robot's heading that it means [rad], where it measures one.
  double heading() const noexcept { return of == Measures::heading ? yaw : psi_other - yaw; }
  double heading_variance() const noexcept {
    return of == Measures::heading ? yaw_variance : yaw_variance + P_other(3, 3);
  }
  /// Whether its numbers are finite and its variances positive; nothing else is believed of one that is not.
  bool is_usable() const noexcept;
};

/// Acceleration and turning of a robot while nobody measures its motion, at most about so much [m/s^2],
/// [rad/s^2].
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
