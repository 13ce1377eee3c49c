/// What renders the cameras' pictures of a scenario, where it was built.
#pragma once

#include <memory>

#include "sightline/scenario/scenario.hpp"
#include "sightline/world/detection_source.hpp"

namespace sightline::mujoco {

/// @throws std::invalid_argument as RenderedDetections, and where EGL or AprilTag were not there to build it
std::unique_ptr<DetectionSource> make_renderer(const Scenario& scenario);

}  // namespace sightline::mujoco
