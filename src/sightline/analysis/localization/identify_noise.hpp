/// Noise of odometry and sensors that explains a recording best.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sightline/analysis/localization/localize_team.hpp"

namespace sightline {

struct IdentifiedNoise {
  struct Number {
    std::string_view key, unit;
    double before = 0.0, value = 0.0;
  };
  TeamNoise noise{};
  std::vector<Number> numbers{};         ///< those that were identified
  double cost_before = 0.0, cost = 0.0;  ///< TeamLocalization::cost
  int runs = 0;                          ///< of the filter
};

/// Maximises the likelihood of the innovations over white noise, lasting errors and correlation
/// times that are above 0 in `run.noise`, one after the other by factors from 1.6 to 1.12. Uses the
/// truth at most for the start and for the anchor. The constants of each robot (scale errors, bias,
/// clock offset, mounting) stay: the filter estimates them itself.
/// @param threads  1 or 2
/// @throws std::invalid_argument as localize_team()
IdentifiedNoise identify_noise(const TeamRecording& recording, const TeamRun& run, int threads = 2);

}  // namespace sightline
