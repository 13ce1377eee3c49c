/// Accuracy of robots that are localized by vision, as drawings of a report.
#pragma once

#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// For each of the first such robots: error with three standard deviations, NEES, and the fit of
/// its detections.
std::vector<Drawing> localization_drawings(const Recording& recording);

}  // namespace sightline
