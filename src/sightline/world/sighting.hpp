/// Conversion of a camera's detection into a measurement for a robot's pose filter.
#pragma once

#include "sightline/estimator.hpp"
#include "sightline/world.hpp"
#include "sightline/world/rigid_motion.hpp"

namespace sightline {

/// Position of the target in S and, if the detection is oriented, its heading in V, with their
/// joint covariance. The measured roll and pitch give the rotation from S to V. The target's own
/// broadcast pose is not filled in.
///
/// A rotation dtheta of the target, in S, changes its heading in V by g^T R_VS dtheta. With its x
/// axis x in V, g = (-x_3 x_1, -x_3 x_2, x_1^2 + x_2^2) / (x_1^2 + x_2^2).
/// @param roll_pitch  measured at the exposure [rad]; unused for a sensor that a gimbal holds level
Measurement sighting_of(const Detection& detection, const SensorMount& mount,
                        const Vec2<double>& roll_pitch) noexcept;

}  // namespace sightline
