/// A camera's detection as a filter of a robot's pose takes it.
#pragma once

#include "sightline/estimate/place.hpp"
#include "sightline/world/detection.hpp"

namespace sightline {

inline Mat<3, 3> matrix(const Rotation& R) noexcept {
  return {{{{R.x.x, R.y.x, R.z.x}, {R.x.y, R.y.y, R.z.y}, {R.x.z, R.y.z, R.z.z}}}};
}

/// The position of the target in S and, where the detection is oriented, its heading in V by the told roll and
/// pitch, with the covariance of both. What the target tells of itself is not filled in.
///
/// A turn dtheta of the target, in S, turns its heading in V by g^T R_VS dtheta, g = (-x_3 x_1, -x_3 x_2, x_1^2 +
/// x_2^2) / (x_1^2 + x_2^2) with its x axis x in V.
/// @param roll_pitch  told, at the exposure; a sensor that a gimbal holds level does without [rad]
Measurement sighting_of(const Detection& detection, const SensorMount& mount,
                        const Vec2<double>& roll_pitch) noexcept;

}  // namespace sightline
