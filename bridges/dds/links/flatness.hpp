/// Differential flatness of a multirotor: attitude and body rates from the motion of its mass.
///
/// Thrust acts along the body's z axis. Acceleration and heading therefore give the attitude, and
/// their rates give the body rates.
#pragma once

#include "sightline/world.hpp"

namespace sightline::dds {

struct FlatAttitude {
  Quaternion q{};    ///< attitude, B to G
  Vec3<double> w{};  ///< angular velocity in B [rad/s]
};

/// Attitude whose thrust gives the acceleration, and body rates that follow its change,
///
///   z_B = (a + g e_z) / |a + g e_z|,   z_B' = (j - (j . z_B) z_B) / |a + g e_z|,
///   w_x = -z_B' . y_B,   w_y = z_B' . x_B,
///
/// where w_z makes the heading turn at rate r. If a_z + g <= 0.1 g (free fall), the attitude is
/// upright.
/// @param a  acceleration in G [m/s^2]
/// @param j  jerk in G [m/s^3]
/// @param d  heading, of length 1
/// @param r  heading rate [rad/s]
FlatAttitude flat_attitude(const Vec3<double>& a, const Vec3<double>& j, const Vec2<double>& d,
                           double r) noexcept;

}  // namespace sightline::dds
