/// Random numbers of one run of a campaign.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

/// Draws one number.
double draw(const Distribution& distribution, RandomStream& random);

struct RunDraw {
  int index = 0;
  std::uint64_t seed = 0;      ///< of all random streams of the run; below 2^53
  std::vector<double> values;  ///< in the order of drawn_names()
};

/// Depends only on the campaign's seed and the index. Each value has its own stream, so that a
/// further draw in the plan does not change the earlier ones.
RunDraw draw_run(const CampaignPlan& plan, std::uint64_t seed, int index);

}  // namespace sightline
