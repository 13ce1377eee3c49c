/// The numbers of one run of a campaign.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

/// One number.
double draw(const Distribution& distribution, RandomStream& random);

struct RunDraw {
  int index = 0;
  std::uint64_t seed = 0;      ///< of all chance within the run; below 2^53
  std::vector<double> values;  ///< as in drawn_names()
};

/// Made from the campaign's seed and the index alone. Each value has a stream of its own, so that another draw
/// in the plan leaves those before it as they were.
RunDraw draw_run(const CampaignPlan& plan, std::uint64_t seed, int index);

}  // namespace sightline
