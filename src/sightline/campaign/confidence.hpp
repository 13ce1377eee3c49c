/// What counted successes say about their probability.
#pragma once

#include <cstdint>

namespace sightline {

struct Interval {
  double low = 0.0, high = 1.0;
};

/// Clopper and Pearson's exact bounds of a probability after `good` successes in `runs` independent trials: each end
/// is wrong with at most half of 1 - confidence,
///
///   P(X >= good | low) = P(X <= good | high) = (1 - confidence) / 2,   X binomial of `runs` trials.
///
/// @param good        0..runs
/// @param confidence  in (0, 1)
Interval clopper_pearson(std::int64_t good, std::int64_t runs, double confidence = 0.95);

/// I_x(a, b), the regularised incomplete beta function; a, b > 0, x in [0, 1].
double incomplete_beta(double a, double b, double x);

}  // namespace sightline
