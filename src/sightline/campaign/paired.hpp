/// What two scenarios that flew the same draws differ by, run by run.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/campaign/confidence.hpp"
#include "sightline/campaign/page.hpp"

namespace sightline {

/// Of independent values, with bounds that hold whatever the distribution, by order statistics: below the bound of rank k
/// are fewer than k values with the probability P(X < k), X binomial of 1/2, at most (1 - confidence) / 2. Few values have
/// the least and the greatest as bounds.
/// @param values  not empty
MedianBounds median_bounds(std::vector<double> values, double confidence = 0.95);

/// Of a column, b compared with a, in the runs that both recovered.
struct Pairing {
  std::int64_t runs = 0;    ///< that both recovered; below, nothing of none
  std::int64_t less = 0;    ///< in which b has less, beyond rounding
  std::int64_t more = 0;    ///< in which b has more
  MedianBounds difference;  ///< b - a
  MedianBounds ratio;       ///< b / a, where a > 0
};

/// @throws std::runtime_error where a table cannot be read, or has no such column
Pairing pair_runs(const CampaignTable& a, const CampaignTable& b, std::string_view column);

/// Runs of both that only one recovered.
struct OutcomePairing {
  std::int64_t runs = 0;  ///< of both tables
  std::int64_t only_a = 0, only_b = 0;
};
/// @throws std::runtime_error where a table cannot be read
OutcomePairing pair_outcomes(const CampaignTable& a, const CampaignTable& b);

/// Outcomes of b compared with those of a, by McNemar's exact test; the energies of b compared with those of a, of all
/// robots and of each that both have.
std::vector<CampaignLine> energy_lines(const CampaignTable& a, const CampaignTable& b);

}  // namespace sightline
