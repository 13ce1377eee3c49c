/// Where tags and cameras lie on a robot, in the frames of apriltag_ros: pure, no messages.
#pragma once

#include "bridges/dds/conversion.hpp"
#include "sightline/world/camera.hpp"

namespace sightline::dds {

/// The frame of a tag in the body B that it is on: x to the right of who looks at it, y up, z out of the plate.
RigidPose tag_on_body(const Tags& tags, int face);

/// A transform from a camera's optical frame C (x right, y down, z ahead) to a tag.
struct OpticalPose {
  Vec3<double> p{};
  Quaternion q{};
};
/// Of a pose in the sensor frame S (x ahead, y left, z up), and back.
OpticalPose in_optical(const RigidPose& in_S);
/// @param q  of length 1
RigidPose from_optical(const Vec3<double>& p, const Quaternion& q);

}  // namespace sightline::dds
