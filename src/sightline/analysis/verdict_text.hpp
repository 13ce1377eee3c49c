/// A verdict in words.
#pragma once

#include "sightline/analysis/verdict.hpp"

namespace sightline {

/// Writes the sentences of a verdict whose numbers are known: `words` and `warnings`.
void describe(Verdict& verdict);

}  // namespace sightline
