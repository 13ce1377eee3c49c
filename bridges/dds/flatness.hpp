/// What a multirotor must do so that its mass moves as planned: its thrust is along its z axis, so acceleration and heading are all of its
/// attitude, and their rates are its rates (it is differentially flat).
#pragma once

#include "sightline/world/rigid_body.hpp"

namespace sightline::dds {

struct FlatAttitude {
  Quaternion q{};    ///< B to G
  Vec3<double> w{};  ///< angular velocity, in B [rad/s]
};

/// The attitude whose thrust makes the acceleration, and the rates that follow its change,
///
///   z_B = (a + g e_z) / |a + g e_z|,   z_B' = (j - (j . z_B) z_B) / |a + g e_z|,   w_x = -z_B' . y_B,   w_y = z_B' . x_B,
///
/// where w_z makes the heading turn with r. Below 0.1 g of lift, where a vehicle falls, it is upright.
/// @param a  acceleration in G [m/s^2]
/// @param j  its rate [m/s^3]
/// @param d  heading, of length 1
/// @param r  rate of the heading [rad/s]
FlatAttitude flat_attitude(const Vec3<double>& a, const Vec3<double>& j, const Vec2<double>& d,
                           double r) noexcept;

}  // namespace sightline::dds
