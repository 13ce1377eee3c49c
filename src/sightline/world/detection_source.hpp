/// Interface that finds tagged bodies in a picture: a noise model, or rendered pictures.
#pragma once

#include <cstddef>
#include <span>

#include "sightline/world/camera.hpp"
#include "sightline/world/detection.hpp"

namespace sightline {

/// Pose in G of a body when a picture is taken, and one period before.
struct ExposedBody {
  RigidPose now{}, before{};
  bool there = true;
};

/// One picture to be taken.
struct Exposure {
  std::size_t camera = 0;               ///< index into CameraOptions::cameras
  double time = 0.0;                    ///< [s]
  double since = 0.0;                   ///< time from `before` to `now` [s]; 0 at the first picture
  std::span<const ExposedBody> bodies;  ///< in team order
};

class DetectionSource {
 public:
  virtual ~DetectionSource() = default;
  /// Finds at most one detection for each body with tags, in the order of the options. The caller
  /// sets stamp and arrival. Never throws.
  /// @return number of entries of `found` that were written
  virtual std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept = 0;
};

/// True pose of S in G at the middle of an exposure.
/// @param turned  the rotation of the real sensor frame in the nominal S
RigidPose camera_pose(const RobotCamera& camera, const Rotation& turned, const RigidPose& body);

/// Rotation of each camera against its nominal mounting (Camera::misalignment), drawn once.
std::vector<Rotation> drawn_misalignments(const CameraOptions& options);

/// Motion of a body in the picture during the exposure [px]; 0 if the body was not in front of the
/// camera.
Vec2<double> smear_of(const CameraOptions& options, const Exposure& exposure, const Rotation& turned,
                      BodyId body);

}  // namespace sightline
