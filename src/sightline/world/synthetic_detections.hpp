/// Detections drawn from the noise of tags in rendered pictures, without rendering.
#pragma once

#include <array>
#include <vector>

#include "sightline/world/detection_source.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/tag_pose.hpp"

namespace sightline {

/// Draws detections from a probability model. A tag with a side of n px at its depth, at an angle i
/// to its normal, is found with the probability
///
///   0.99 / (1 + exp((n_0 - n cos(i)^(7/8)) / 0.7)),   i < 75 degrees,
///   n_0 = 10.6 px sharp, 20 px if smeared over 2 px or more,
///
/// provided that it is in the picture with its white border and no hull hides its centre or a
/// corner. The curve is the maximum-likelihood logistic fit to 2197 rendered plates.
///
/// The pose over all tags found has the covariance of PoseInformation with corner_sigma(). One tag
/// alone, within 20 degrees of frontal view, may give its mirror image (mirrored()). The share is
/// 35 % of the pictures below 16 px and 20 % up to 22 px, if the body is as upright in the mirror
/// image.
///
/// Camera::outliers displaces the body: half of the outliers anywhere in the view, half to 1.1 to
/// 1.5 times the distance. Camera::flips rotates it by 0.35 to 1.35 rad about its z axis. Both
/// report the covariance of the undisturbed pose.
///
/// Each pair of camera and body has its own random stream, with the same number of draws for each
/// picture.
class SyntheticDetections final : public DetectionSource {
 public:
  explicit SyntheticDetections(const Team& team, const CameraOptions& options);

  std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept override;

  /// Probability that a tag with a side of n px is found, at an incidence angle with this cosine.
  /// @param smear  motion of the tag in the picture during the exposure [px]
  static double probability(double n, double cosine, double smear);
  /// Largest incidence angle at which a tag is found [rad].
  static constexpr double incidence_max = 1.309;
  /// Side [px] at which about half of all sharp tags in frontal view are found. At an angle it is
  /// half_found / readable().
  static constexpr double half_found = 10.6;
  /// cos(i)^(7/8): factor by which the incidence angle i reduces the apparent size of a tag.
  static double readable(double cosine);
  /// Probability that a single tag gives its mirror image.
  static double mirror_share(double n, double cosine);

 private:
  struct Draws;
  bool detect(const Exposure& exposure, std::size_t tags, Detection& found) noexcept;
  bool hidden(const Exposure& exposure, BodyId observer, BodyId target, const Vec3<double>& eye,
              const Vec3<double>& point) const noexcept;

  CameraOptions options_;
  std::vector<Rotation> turned_;
  std::vector<RandomStream> streams_;  // one for each pair of camera and body with tags
};

}  // namespace sightline
