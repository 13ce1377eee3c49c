/// Where the bodies went, from above and from the side.
#pragma once

#include "sightline/report/curves.hpp"

namespace sightline {

/// Paths from above; each 1.67 s a line from observer to target and the observer's heading, as Fig. 20; at the end
/// the footprint of each observer's cone: where at its own depression a horizontal cut of the cone lies. Below,
/// the paths over x or y, whichever is longer, and z.
Drawing paths_drawing(const Recording& recording, const Curves& curves);

}  // namespace sightline
