/// How near the robots of a swarm came, as a drawing of a flight's report.
#pragma once

#include <optional>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// The distance of the two robots that are nearest, the pairs that were kept apart, and how far the robots are from
/// where they are asked to be in the end; none where no robots are kept apart.
std::optional<Drawing> swarm_drawing(const Recording& recording);

}  // namespace sightline
