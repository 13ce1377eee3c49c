/// Text of a verdict.
#pragma once

#include "sightline/analysis/verdict.hpp"

namespace sightline {

/// Writes `words` and `warnings` of a verdict from its numbers.
void describe(Verdict& verdict);

}  // namespace sightline
