/// Pose and covariance of a body from the corners of its tags in a picture.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "sightline/base/matrix.hpp"
#include "sightline/world/camera.hpp"

namespace sightline {

/// A tag found in a picture.
struct FoundTag {
  int face = 0;
  std::array<Vec2<double>, 4>
      corners{};  ///< in the order of Tags::corners(), in the coordinates of Camera::project() [px]
};

/// Standard deviation of a corner's coordinates [px] for a tag with a side of n px. Measured on
/// rendered pictures, docs/localization.md.
/// @param cos_incidence  cosine of the angle between the tag's normal and the line of sight
/// @param noise  of a pixel, of 255 grey levels
/// @param smear  motion of the tag in the picture during the exposure [px]
double corner_sigma(double n, double cos_incidence, double noise, double smear);
/// Cosine of the incidence angle of a face, for a body at this pose in S.
double cos_incidence(const Tags& tags, int face, const RigidPose& pose);

/// Information matrix J^T J of the corner positions over the body's pose in S (position, rotation),
/// weighted by 1 / sigma^2.
///
/// In frontal view, a rotation of a single plate hardly moves its corners at first order. At second
/// order they move by n theta^2 / 4, so the rotation is known to about theta^2 = 2 sigma / n. The
/// matrix includes that information.
class PoseInformation {
 public:
  PoseInformation(const Camera& camera, const Tags& tags, const RigidPose& pose);

  /// Adds one tag whose corners have the standard deviation sigma [px].
  void add(int face, double sigma) noexcept;
  /// Inverse of the information, in the order of Detection::covariance; none if no tag was added.
  std::optional<Mat<6, 6>> covariance() const noexcept;

 private:
  const Camera& camera_;
  const Tags& tags_;
  RigidPose pose_;
  double focal_, bend_ = 0.0;
  Mat<6, 6> sum_{};
};

/// A pose estimated from corners.
struct TagPose {
  RigidPose pose{};  ///< of the body in S
  double rms = 0.0;  ///< root mean square of the reprojection errors [px]
};

/// Least-squares pose of all corners, from a first guess, by Levenberg-Marquardt. None if the guess
/// has a corner behind the camera.
std::optional<TagPose> refined(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const RigidPose& guess);

/// Mirror solution of a tag's pose: its plate is reflected about the line of sight. A small tag in
/// nearly frontal view does not distinguish the two.
RigidPose mirrored(const Tags& tags, int face, const RigidPose& pose);

/// Pose of all tags found, without a guess. Each single tag gives two candidates, which are refined
/// over all tags. Of the candidates that fit nearly as well as the best, the one whose z axis is
/// nearest to `up` is returned. None if the corners match no plate in front of the camera.
/// @param up  in S
std::optional<TagPose> pose_of(const Camera& camera, const Tags& tags, std::span<const FoundTag> found,
                               const Vec3<double>& up);

}  // namespace sightline
