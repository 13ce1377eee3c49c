/// Camera views of a run, as figures of its page.
#pragma once

#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// Six views, evenly spaced in time, of each of the first four cameras with detections: the plates
/// that face the camera, at their detected poses. The code of a tag is not drawn.
std::vector<Figure> camera_figures(const Recording& recording);

}  // namespace sightline
