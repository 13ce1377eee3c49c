/// Detections that are drawn by the noise of tags in rendered pictures, without a picture.
#pragma once

#include <array>
#include <vector>

#include "sightline/world/detection_source.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/tag_pose.hpp"

namespace sightline {

/// A tag whose side has n px at its depth, seen at an angle i to its normal, is found with the probability
///
///   0.99 / (1 + exp((n_0 - n cos(i)^(7/8)) / 0.7)),   i < 75 degrees,   n_0 = 10.6 px sharp, 20 px smeared over 2 px and more,
///
/// where it is in the picture with its white border, and where no hull hides its middle or one of its corners: the logistic curve that is
/// likeliest for 2197 rendered plates. The pose over all tags found has the covariance of PoseInformation with corner_sigma(). One tag alone,
/// within 20 degrees of being seen from ahead, gives its mirror image (mirrored()) in 35 % of the pictures below 16 px and in 20 % up to
/// 22 px, where the body stands as upright in it.
///
/// Camera::outliers puts the body elsewhere, half of them anywhere in the view and half of them 1.1 to 1.5 times as far; Camera::flips turns it by
/// 0.35 to 1.35 rad about the vertical. Both say the covariance of what is true.
///
/// Each camera and body has a stream of its own, with the same number of draws for each picture.
class SyntheticDetections final : public DetectionSource {
 public:
  explicit SyntheticDetections(const Team& team, const CameraOptions& options);

  std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept override;

  /// Probability that a tag is found, whose side has n px and which is seen at an angle of that cosine.
  static double probability(double n, double cosine, double smear);
  /// Greatest angle to its normal at which a tag is found [rad].
  static constexpr double incidence_max = 1.309;
  /// Of a sharp tag of so many pixels, seen from ahead, half of all are found; seen at an angle, of that many over readable().
  static constexpr double half_found = 10.6;
  /// cos(i)^(7/8): as if the tag were smaller by that.
  static double readable(double cosine);
  /// That a single tag gives its mirror image.
  static double mirror_share(double n, double cosine);

 private:
  struct Draws;
  bool detect(const Exposure& exposure, std::size_t tags, Detection& found) noexcept;
  bool hidden(const Exposure& exposure, BodyId observer, BodyId target, const Vec3<double>& eye,
              const Vec3<double>& point) const noexcept;

  CameraOptions options_;
  std::vector<Rotation> turned_;
  std::vector<RandomStream> streams_;  // of each camera and body with tags
};

}  // namespace sightline
