/// Detections in rendered pictures: MuJoCo's camera, a lens and a sensor, AprilTag, and the pose of all tags found.
#pragma once

#include <optional>
#include <vector>

#include "sightline/world/detection_source.hpp"
#include "sightline/world/synthetic_detections.hpp"
#include "worlds/mujoco/camera/picture.hpp"
#include "worlds/mujoco/camera/scene.hpp"
#include "worlds/mujoco/camera/tag_finder.hpp"

namespace sightline::mujoco {

/// A picture is blurred by the lens, smeared as its nearest body with tags moves, and noisy. Of the poses that fit the corners the one is
/// taken whose body stands most upright, by the observer's attitude, which is told with an error of 0.012 rad. The covariance is that of
/// PoseInformation.
///
/// Cameras without `render` see as SyntheticDetections. Finding takes memory, and time.
class RenderedDetections final : public DetectionSource {
 public:
  /// @throws std::invalid_argument as Scene
  RenderedDetections(const Team& team, const CameraOptions& options,
                     const std::optional<ModelFile>& surroundings = {});

  std::size_t find(const Exposure& exposure, std::span<Detection> found) noexcept override;

  /// The last picture of that camera.
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
