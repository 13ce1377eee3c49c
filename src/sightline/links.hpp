/// Reading of scenarios with links to real robots. The flight itself needs a bridge, as sightline::dds.
#pragma once

#include "sightline/scenario/registry.hpp"

namespace sightline {

/// The parts with a reader of [fleet] and of links (scenario/links.hpp), unless they have one.
Registry with_links(Registry parts = {});

}  // namespace sightline
