#include "worlds/mujoco/renderer.hpp"

#ifdef SIGHTLINE_PICTURES
#include "sightline/scenario/read_camera.hpp"
#include "worlds/mujoco/camera/rendered_detections.hpp"
#else
#include "sightline/base.hpp"
#endif

namespace sightline::mujoco {

#ifdef SIGHTLINE_PICTURES
std::unique_ptr<DetectionSource> make_renderer(const ScenarioSpec& scenario) {
  return std::make_unique<RenderedDetections>(scenario.team, camera_options(scenario), scenario.model);
}
#else
std::unique_ptr<DetectionSource> make_renderer(const ScenarioSpec&) {
  throw_invalid("a camera has render = true, expected false: this program was built without EGL or AprilTag");
}
#endif

}  // namespace sightline::mujoco
