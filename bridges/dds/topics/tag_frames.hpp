/// Poses of tags and cameras on a robot, in the frames of apriltag_ros: pure functions, no
/// messages.
#pragma once

#include "bridges/dds/topics/conversion.hpp"
#include "sightline/sensors.hpp"

namespace sightline::dds {

/// Tag frame in the body frame B: x to the right for a viewer in front of the tag, y up, z out of
/// the plate.
RigidPose tag_on_body(const Tags& tags, int face);

/// Transform from a camera's optical frame C (x right, y down, z forward) to a tag.
struct OpticalPose {
  Vec3<double> p{};
  Quaternion q{};
};
/// Optical pose of a pose in the sensor frame S (x forward, y left, z up), and the inverse.
OpticalPose in_optical(const RigidPose& in_S);
/// @param q  of length 1
RigidPose from_optical(const Vec3<double>& p, const Quaternion& q);

}  // namespace sightline::dds
