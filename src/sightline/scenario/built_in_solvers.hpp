/// The library's own solvers, as entries of a registry.
#pragma once

#include "sightline/registry.hpp"

namespace sightline {

/// Adds them; the first is the default.
void add_built_in(SolverList& solvers);

}  // namespace sightline
