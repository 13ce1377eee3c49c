/// The scene of the cameras, for rendering only: the team's bodies with their tags and hulls, and
/// the surroundings.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/sensors.hpp"
#include "worlds/mujoco/camera/offscreen.hpp"
#include "worlds/mujoco/camera/tag_finder.hpp"
#include "worlds/mujoco/engine.hpp"

namespace sightline::mujoco {

/// Tag numbers of a body: the first of its faces has number `first`, the next ones follow.
struct TagNumbers {
  BodyId body{};
  int first = 0, count = 0;
};
/// Numbers in the order of the options. @throws std::invalid_argument if the family has too few
/// tags
std::vector<TagNumbers> number_tags(const CameraOptions& options);

/// The MJCF of the scene: one mocap body for each body of the team and for each camera.
std::string scene_of(const Team& team, const CameraOptions& options,
                     const std::optional<ModelFile>& surroundings);

/// Renders the scene with MuJoCo on its own context. One thread at a time.
///
/// A body with tags is drawn as its plates and a box within them. Any other body is drawn as its
/// hull, or not at all if it has none. Pictures exclude the observer's own body and bodies that are
/// not present.
class Scene {
 public:
  /// @throws std::invalid_argument if MuJoCo rejects the surroundings, or there is no OpenGL
  Scene(const Team& team, const CameraOptions& options, const std::optional<ModelFile>& surroundings,
        const TagFinder& tags);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// The picture of a camera at these poses: three bytes per pixel, bottom row first; empty if
  /// OpenGL failed.
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
  std::vector<int> eyes_;     // mocap index of each camera
  std::vector<float> alpha_;  // of each geom, from the model
  mjvScene scene_{};
  mjvOption option_{};
  mjrContext context_{};
  std::vector<std::uint8_t> rgb_;
};

}  // namespace sightline::mujoco
