/// Distances within a swarm, as a drawing of a flight's report.
#pragma once

#include <optional>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// Distance of the two nearest robots, number of pairs kept apart, and distance of the robots from
/// their final references; none if no robots are kept apart.
std::optional<Drawing> swarm_drawing(const Recording& recording);

}  // namespace sightline
