/// Detections in rendered pictures: MuJoCo's camera, models of lens and sensor, AprilTag, and the
/// body pose from all tags found.
#pragma once

#include <optional>
#include <vector>

#include "sightline/sensors.hpp"
#include "worlds/mujoco/camera/picture.hpp"
#include "worlds/mujoco/camera/scene.hpp"
#include "worlds/mujoco/camera/tag_finder.hpp"

namespace sightline::mujoco {

/// A picture has lens blur, motion blur of its nearest body with tags, and noise. Several poses may
/// fit the corners: the chosen one has the body most upright. That choice uses the observer's
/// attitude with an error of 0.012 rad. The covariance is that of PoseInformation.
///
/// Cameras without `render` use SyntheticDetections. find() allocates memory and takes time.
class RenderedDetections final : public DetectionSource {
 public:
  /// @throws std::invalid_argument as Scene
  RenderedDetections(const Team& team, const CameraOptions& options,
                     const std::optional<ModelFile>& surroundings = {});

  std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept override;

  /// The last picture of a camera.
  const Picture& picture(std::size_t camera) const { return pictures_.at(camera); }

 private:
  bool take(const Exposure& exposure, const RigidPose& eye) noexcept;
  bool detect(const Exposure& exposure, std::size_t tags, const Vec3<double>& up,
              Detection& found) const noexcept;

  CameraOptions options_;
  std::vector<Rotation> turned_;
  std::vector<TagNumbers> numbers_;
  std::vector<RandomStream> chance_;  // of each camera
  SyntheticDetections synthetic_;
  TagFinder finder_;
  Scene scene_;
  std::vector<Picture> pictures_;
  const std::vector<TagInPicture>* seen_ = nullptr;
};

}  // namespace sightline::mujoco
