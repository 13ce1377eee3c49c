/// Robot position that one measurement implies.
#pragma once

#include "sightline/base/rotation.hpp"
#include "sightline/estimate/measurement.hpp"
#include "sightline/model/frames.hpp"

namespace sightline {

/// Attitude R_BS of the sensor S in the body B; the sensor's x axis in B is (cos beta, 0, -sin
/// beta).
inline Mat<3, 3> sensor_attitude(const SensorMount& mount) noexcept { return turn_y(mount.pitch); }

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
  const Mat<3, 3> R_GB = turn_z(psi) * R_VB, R_GS = R_GB * sensor_attitude(mount);
  const Vec3<double> r = R_GB * Vec3<double>{mount.offset, 0, 0} + R_GS * z.z;
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
