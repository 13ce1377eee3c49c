/// How well robots that are localized by vision knew where they were, as drawings of a report.
#pragma once

#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// For each of the first robots that are localized by vision: error with three standard deviations, NEES, and how its
/// detections fitted.
std::vector<Drawing> localization_drawings(const Recording& recording);

}  // namespace sightline
