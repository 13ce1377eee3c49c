/// Statistics of a campaign: proportions and medians with confidence bounds, and a test of pairs.
#pragma once

#include <cstdint>
#include <vector>

namespace sightline {

struct Interval {
  double low = 0.0, high = 1.0;
};

/// Wilson's bounds of a probability after `good` successes in `runs` independent trials (Wilson
/// 1927), with the normal quantile z:
///
///   (p + z^2 / (2 n) +- z sqrt(p (1 - p) / n + z^2 / (4 n^2))) / (1 + z^2 / n),   p = good / n
///
/// @param good  0..runs, runs > 0
/// @param confidence  in (0, 1)
Interval wilson(std::int64_t good, std::int64_t runs, double confidence = 0.95);

/// Bounds of a probability after `seen` events in `runs` independent trials (Clopper and Pearson 1934): exact,
/// each side has at most half of the remaining probability.
/// @param seen  0..runs, runs > 0
/// @param confidence  in (0, 1)
Interval clopper_pearson(std::int64_t seen, std::int64_t runs, double confidence = 0.95);

/// The standard normal distribution function, and its inverse; p in (0, 1).
double normal_probability(double z);
double normal_quantile(double p);

/// A median and its confidence bounds.
struct MedianBounds {
  double low = 0.0, median = 0.0, high = 0.0;
};

/// A median with the bounds of the percentile bootstrap (Efron 1979): the quantiles of the medians
/// of `resamples` draws with replacement. The seed determines the draws.
/// @param values  not empty
MedianBounds bootstrap_median(std::vector<double> values, double confidence = 0.95, int resamples = 1000,
                              std::uint64_t seed = 1);

/// Two-sided p of the sign test, and of McNemar's exact test: among `less` + `more` differing
/// pairs, both signs are equally likely. 1 if no pair differs.
double sign_test(std::int64_t less, std::int64_t more);

/// I_x(a, b), the regularised incomplete beta function; a, b > 0, x in [0, 1].
double incomplete_beta(double a, double b, double x);

}  // namespace sightline
