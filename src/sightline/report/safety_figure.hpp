/// What supervisor and barrier did over a flight, as a drawing of its report.
#pragma once

#include <optional>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// Rungs of the robots over time, and where the barrier acted; none where neither was there or nothing happened.
std::optional<Drawing> safety_drawing(const Recording& recording);

}  // namespace sightline
