/// Determines whether a potential keeps two bodies apart, and whether one body observes the other
/// by it. A declared property takes precedence; otherwise, as for limits as text, the stated limit
/// is sampled.
#pragma once

#include <vector>

#include "sightline/potential.hpp"

namespace sightline {

/// Whether its limit is violated at distance 0, from the observer or from its sensor, and holds at
/// 10 km. Tested on 64 directions, headings and velocities.
bool limits_distance_from_below(const Potential& potential);

/// Whether it limits the distance of two bodies from below: as declared, else
/// limits_distance_from_below().
bool keeps_apart(const Potential& potential);

/// The limits in it that keep two bodies apart. This is the potential itself if keeps_apart(), else
/// those conjuncts of a region that do. "0.5 m < range < 4 m" has one.
std::vector<Potential> keep_outs(const Potential& potential);

/// Whether the first body observes the second with a sensor: as declared, else a limit in the
/// sensor frame other than a least distance, such as "range > 1 m".
bool observes(const Potential& potential);

}  // namespace sightline
