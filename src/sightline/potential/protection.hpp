/// What of a potential keeps two bodies apart, and whether one observes the other by it: as the potential says of itself,
/// else, as for limits as text, found by looking at the limit that it states.
#pragma once

#include <vector>

#include "sightline/potential/potential.hpp"

namespace sightline {

/// Whether its limit is broken wherever both bodies are at one place (or the target at the observer's sensor) and holds
/// wherever they are 10 km apart, on 64 directions, headings and velocities.
bool limits_distance_from_below(const Potential& potential);

/// Whether it limits the distance of two bodies from below: as it says of itself, else limits_distance_from_below().
bool keeps_apart(const Potential& potential);

/// The limits in it that keep two bodies apart: the potential itself if keeps_apart(), else those of a region that all
/// have to hold and do. "0.5 m < range < 4 m" has one.
std::vector<Potential> keep_outs(const Potential& potential);

/// Whether the first body looks at the second with a sensor: a limit in the sensor's frame that does not just keep
/// them apart, as "range > 1 m" does.
bool observes(const Potential& potential);

}  // namespace sightline
