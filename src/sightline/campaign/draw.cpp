#include <algorithm>

#include "sightline/analysis.hpp"
#include "sightline/campaign/confidence.hpp"

namespace sightline {
namespace {

/// The value of a choice at a share of its probability, in (0, 1].
double choice_at(const Distribution& d, double share) {
  std::size_t i = 0;
  while (i + 1 < d.values.size() && share > d.fractions[i]) share -= d.fractions[i++];
  return d.values[i];
}

double quantile(const Distribution& d, double share) {
  if (share <= d.fraction) return d.constant;
  share = (share - d.fraction) / (1 - d.fraction);
  switch (d.kind) {
    case Distribution::Kind::uniform:
      return d.values[0] + (d.values[1] - d.values[0]) * share;
    case Distribution::Kind::normal:
      return d.values[0] + d.values[1] * normal_quantile(share);
    case Distribution::Kind::choice:
      break;
  }
  return choice_at(d, share);
}

/// The distributions of the plan's numbers, in the order of drawn_names().
std::vector<const Distribution*> distributions(const CampaignPlan& plan) {
  std::vector<const Distribution*> all;
  for (const StartDraw& start : plan.starts) {
    all.insert(all.end(), {&start.range, &start.bearing, &start.height});
    if (start.heading) all.push_back(&*start.heading);
    if (start.velocity) all.insert(all.end(), 2, &*start.velocity);
  }
  for (const NumberDraw& number : plan.draws) all.push_back(&number.distribution);
  return all;
}

}  // namespace

double draw(const Distribution& d, RandomStream& random) {
  if (d.fraction > 0 && random.uniform() <= d.fraction) return d.constant;
  switch (d.kind) {
    case Distribution::Kind::uniform:
      return d.values[0] + (d.values[1] - d.values[0]) * random.uniform();
    case Distribution::Kind::normal:
      return d.values[0] + d.values[1] * random.normal();
    case Distribution::Kind::choice:
      break;
  }
  return choice_at(d, random.uniform());
}

RunDraw draw_run(const CampaignPlan& plan, std::uint64_t seed, int index) {
  RunDraw run{.index = index, .seed = RandomStream(seed, StreamId::run, index).bits() >> 11, .values = {}};
  for (const Distribution* distribution : distributions(plan)) {
    RandomStream random(run.seed, StreamId::draw, static_cast<int>(run.values.size()));
    run.values.push_back(draw(*distribution, random));
  }
  return run;
}

RunDraw run_at(const CampaignPlan& plan, std::span<const double> point, std::uint64_t seed, int index) {
  RunDraw run{.index = index, .seed = seed, .values = {}};
  const std::vector<const Distribution*> all = distributions(plan);
  for (std::size_t i = 0; i < all.size(); ++i) {
    // Beyond 7 standard deviations a share is 0 or 1 but for rounding.
    const double share = normal_probability(std::clamp(point[i], -7.0, 7.0));
    run.values.push_back(quantile(*all[i], share));
  }
  return run;
}

}  // namespace sightline
