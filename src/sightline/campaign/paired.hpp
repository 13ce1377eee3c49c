/// Run-by-run comparison of two scenarios that flew the same draws.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/campaign/confidence.hpp"
#include "sightline/campaign/page.hpp"

namespace sightline {

/// Median of independent values, with bounds for any distribution, by order statistics. The lower
/// bound is the value of rank k with P(X < k) <= (1 - confidence) / 2, X binomial with probability
/// 1/2; the upper bound is symmetric. With few values the bounds are the least and the greatest
/// value.
/// @param values  not empty
MedianBounds median_bounds(std::vector<double> values, double confidence = 0.95);

/// Comparison of a column of b with that of a, over the runs that both recovered.
struct Pairing {
  std::int64_t runs = 0;    ///< that both recovered
  std::int64_t less = 0;    ///< in which b is less, beyond rounding
  std::int64_t more = 0;    ///< in which b is more, beyond rounding
  MedianBounds difference;  ///< b - a
  MedianBounds ratio;       ///< b / a, over runs with a > 0
};

/// @throws std::runtime_error if a table cannot be read or lacks the column
Pairing pair_runs(const CampaignTable& a, const CampaignTable& b, std::string_view column);

/// Runs of both tables that only one recovered.
struct OutcomePairing {
  std::int64_t runs = 0;  ///< of both tables
  std::int64_t only_a = 0, only_b = 0;
};
/// @throws std::runtime_error if a table cannot be read
OutcomePairing pair_outcomes(const CampaignTable& a, const CampaignTable& b);

/// Outcomes of b compared with those of a, by McNemar's exact test; energies of b compared with
/// those of a, in total and for each robot that both have.
std::vector<CampaignLine> energy_lines(const CampaignTable& a, const CampaignTable& b);

}  // namespace sightline
