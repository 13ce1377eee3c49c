/// What cameras look at: the team's bodies with their tags and hulls, and what else there is, for pictures alone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/world/detection_source.hpp"
#include "worlds/mujoco/camera/offscreen.hpp"
#include "worlds/mujoco/camera/tag_finder.hpp"
#include "worlds/mujoco/engine.hpp"

namespace sightline::mujoco {

/// Where the tags of a body begin: its first face has this number, the next ones follow.
struct TagNumbers {
  BodyId body{};
  int first = 0, count = 0;
};
/// In the order of the options. @throws std::invalid_argument for more tags than the family has
std::vector<TagNumbers> number_tags(const CameraOptions& options);

/// The MJCF of the scene: a body that mocap moves for each of the team and for each camera.
std::string scene_of(const Team& team, const CameraOptions& options,
                     const std::optional<ModelFile>& surroundings);

/// Renders it by MuJoCo on a context of its own. One thread at a time.
///
/// A body with tags is its plates and a box within them; any other is its hull, or nothing where it has none. The observer's own body is
/// not in its pictures, nor is a body that is not there.
class Scene {
 public:
  /// @throws std::invalid_argument where MuJoCo refuses the surroundings, or there is no OpenGL
  Scene(const Team& team, const CameraOptions& options, const std::optional<ModelFile>& surroundings,
        const TagFinder& tags);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// The picture of a camera at these poses: three bytes for a pixel, the bottom row first; empty where OpenGL failed.
  std::span<const std::uint8_t> render(const Exposure& exposure, const RigidPose& camera) noexcept;

 private:
  struct Shown {
    int mocap = 0, first_geom = 0, geoms = 0;
  };
  struct Call;

  void draw_tags(const TagFinder& tags);
  void place(int mocap, const RigidPose& pose) noexcept;
  void show(const Shown& body, bool visible) noexcept;
  bool draw(std::size_t camera) noexcept;

  CameraOptions options_;
  Offscreen offscreen_;
  ModelPointer model_;
  DataPointer data_;
  std::vector<Shown> bodies_;
  std::vector<int> eyes_;     // mocap of each camera
  std::vector<float> alpha_;  // of each geom, as the model has it
  mjvScene scene_{};
  mjvOption option_{};
  mjrContext context_{};
  std::vector<std::uint8_t> rgb_;
};

}  // namespace sightline::mujoco
