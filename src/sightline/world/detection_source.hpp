/// The seam between a camera and what finds bodies in its pictures: a model of the noise, or pictures that are rendered.
#pragma once

#include <cstddef>
#include <span>

#include "sightline/world/camera.hpp"
#include "sightline/world/detection.hpp"

namespace sightline {

/// A body when a picture is taken, and one period before, in G.
struct ExposedBody {
  RigidPose now{}, before{};
  bool there = true;
};

/// A picture.
struct Exposure {
  std::size_t camera = 0;               ///< of CameraOptions
  double time = 0.0;                    ///< [s]
  double since = 0.0;                   ///< from `before` to `now` [s]; 0: at the first
  std::span<const ExposedBody> bodies;  ///< of the team, in its order
};

class DetectionSource {
 public:
  virtual ~DetectionSource() = default;
  /// What is found in it: at most one detection of each body with tags, in the order of the options. Stamp and arrival are the
  /// caller's. Never throws.
  /// @return how many of `found` were written
  virtual std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept = 0;
};

/// The pose of S in G at the middle of an exposure, as it truly is; `turned` is S as it is in S as it is told.
RigidPose camera_pose(const RobotCamera& camera, const Rotation& turned, const RigidPose& body);

/// How each camera is turned against its mounting (Camera::misalignment), drawn once.
std::vector<Rotation> drawn_misalignments(const CameraOptions& options);

/// The way of a body in the picture while it is exposed [px]; 0 where it was behind the camera.
Vec2<double> smear_of(const CameraOptions& options, const Exposure& exposure, const Rotation& turned,
                      BodyId body);

}  // namespace sightline
