#include "sightline/analysis.hpp"

namespace sightline {

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
  double left = random.uniform();
  std::size_t i = 0;
  while (i + 1 < d.values.size() && left > d.fractions[i]) left -= d.fractions[i++];
  return d.values[i];
}

RunDraw draw_run(const CampaignPlan& plan, std::uint64_t seed, int index) {
  RunDraw run{.index = index, .seed = RandomStream(seed, StreamId::run, index).bits() >> 11, .values = {}};
  const auto next = [&](const Distribution& distribution) {
    RandomStream random(run.seed, StreamId::draw, static_cast<int>(run.values.size()));
    run.values.push_back(draw(distribution, random));
  };
  for (const StartDraw& start : plan.starts) {
    next(start.range);
    next(start.bearing);
    next(start.height);
    if (start.heading) next(*start.heading);
    if (!start.velocity) continue;
    next(*start.velocity);
    next(*start.velocity);
  }
  for (const NumberDraw& number : plan.draws) next(number.distribution);
  return run;
}

}  // namespace sightline
