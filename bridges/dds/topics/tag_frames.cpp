#include "bridges/dds/topics/tag_frames.hpp"

namespace sightline::dds {
namespace {

const Rotation R_SC = {{0, -1, 0}, {0, 0, -1}, {1, 0, 0}};

}  // namespace

RigidPose tag_on_body(const Tags& tags, int face) {
  const Vec3<double> n = tags.normal(face);
  return {tags.centre(face), {{-n.y, n.x, 0}, {0, 0, 1}, n}};
}

OpticalPose in_optical(const RigidPose& in_S) {
  return {R_SC.to_B(in_S.p), quaternion(between(R_SC, in_S.R))};
}

RigidPose from_optical(const Vec3<double>& p, const Quaternion& q) {
  return {R_SC.to_G(p), compose(R_SC, rotation(q))};
}

}  // namespace sightline::dds
