/// What of a potential keeps two bodies apart, and whether one watches the other by it: asked of the limit that the
/// potential states, so that it holds for every kind and for limits as text.
#pragma once

#include <vector>

#include "sightline/potential/potential.hpp"

namespace sightline {

/// Whether it limits the distance of two bodies from below: its limit is broken wherever both are at one place (or the
/// target at the observer's sensor) and holds wherever they are 10 km apart, on 64 directions, headings and velocities.
bool keeps_apart(const Potential& potential);

/// The limits in it that keep two bodies apart: the potential itself if keeps_apart(), else those of a region that all
/// have to hold and do. "0.5 m < range < 4 m" has one.
std::vector<Potential> keep_outs(const Potential& potential);

/// Whether the first body looks at the second with a sensor: a limit in the sensor's frame that does not just keep
/// them apart, as "range > 1 m" does.
bool watches(const Potential& potential);

}  // namespace sightline
