/// The pose of a body from the corners of its tags in a picture, and how sure it is.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "sightline/base/matrix.hpp"
#include "sightline/world/camera.hpp"

namespace sightline {

/// A tag that was found in a picture.
struct FoundTag {
  int face = 0;
  std::array<Vec2<double>, 4>
      corners{};  ///< in the order of Tags::corners(), as Camera::project() has them [px]
};

/// Standard deviation of a corner's coordinates [px], of a tag whose side is n px: measured on rendered pictures, docs/localization.md.
/// @param cos_incidence  of the angle between its normal and the line of sight
/// @param noise  of a pixel, of 255 grey levels
/// @param smear  way of the tag in the picture while it is exposed [px]
double corner_sigma(double n, double cos_incidence, double noise, double smear);
/// That cosine, of a face of a body at this pose in S.
double cos_incidence(const Tags& tags, int face, const RigidPose& pose);

/// J^T J of the corners' places over the pose of the body in S, position and turn, each weighed by 1 / sigma^2.
///
/// The turn of a single plate seen from ahead hardly moves its corners at first order. At second order they move by n theta^2 / 4, so it is
/// known to about theta^2 = 2 sigma / n all the same; that is part of the information.
class PoseInformation {
 public:
  PoseInformation(const Camera& camera, const Tags& tags, const RigidPose& pose);

  /// One more tag, whose corners are known to within sigma [px].
  void add(int face, double sigma) noexcept;
  /// Its inverse, in the order of Detection::covariance; none where no tag was added.
  std::optional<Mat<6, 6>> covariance() const noexcept;

 private:
  const Camera& camera_;
  const Tags& tags_;
  RigidPose pose_;
  double focal_, bend_ = 0.0;
  Mat<6, 6> sum_{};
};

/// A pose that corners say.
struct TagPose {
  RigidPose pose{};  ///< of the body in S
  double rms = 0.0;  ///< of what the corners are off by [px]
};

/// The pose that leaves the least squares of all corners, from a first guess, by Levenberg and Marquardt. None where the guess has a
/// corner behind the camera.
std::optional<TagPose> refined(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const RigidPose& guess);

/// The pose that the mirror image of a tag says: its plate turned to the other side of the line of sight. A small tag seen
/// from nearly ahead leaves both.
RigidPose mirrored(const Tags& tags, int face, const RigidPose& pose);

/// The pose of all tags found, from no guess: of the two that each single tag says, refined over all, the one that fits best; of those that
/// fit nearly as well, the one whose z axis is nearest to `up`, in S.
/// None where the corners are of no plate ahead.
std::optional<TagPose> pose_of(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const Vec3<double>& up);

}  // namespace sightline
