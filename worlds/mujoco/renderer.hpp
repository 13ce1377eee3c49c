/// The renderer of the cameras' pictures, if this build has it.
#pragma once

#include <memory>

#include "sightline/scenario.hpp"
#include "sightline/sensors.hpp"

namespace sightline::mujoco {

/// @throws std::invalid_argument as RenderedDetections, and if the build had no EGL or AprilTag
std::unique_ptr<DetectionSource> make_renderer(const ScenarioSpec& scenario);

}  // namespace sightline::mujoco
