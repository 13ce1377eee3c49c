/// Actions of supervisor and barrier in a flight, as a drawing of its report.
#pragma once

#include <optional>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// Fallback levels of the robots over time, and intervals in which the barrier acted. None if the
/// run had neither supervisor nor barrier, or neither acted.
std::optional<Drawing> safety_drawing(const Recording& recording);

}  // namespace sightline
