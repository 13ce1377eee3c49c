/// What cameras saw, as pictures of a run's page.
#pragma once

#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// Pictures of the first four cameras that detected something, six each, evenly over what they detected: the plates that look at
/// the camera, where a detection says that they are. The code of a tag is not drawn.
std::vector<Figure> camera_figures(const Recording& recording);

}  // namespace sightline
