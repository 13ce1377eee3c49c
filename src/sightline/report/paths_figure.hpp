/// Paths of the bodies, from above and from the side.
#pragma once

#include "sightline/report/curves.hpp"

namespace sightline {

/// Paths from above. Each 1.67 s a line from observer to target and the observer's heading, as in
/// Fig. 20. At the end the footprint of each observer's cone: the horizontal section of the cone at
/// its depression. Below, the paths in the longer of x and y over z.
Drawing paths_drawing(const Recording& recording, const Curves& curves);

}  // namespace sightline
