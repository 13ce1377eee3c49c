#include "sightline/campaign/rare_event.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "sightline/world.hpp"

namespace sightline {
namespace {

/// An event with a known probability.
struct Known {
  std::string name;
  int dimensions;
  double probability;
  std::function<double(const Trial&)> severity;
};

double below(double z) { return std::erfc(z / std::sqrt(2.0)) / 2; }  // P(normal number > z)

std::vector<Known> known_events() {
  const auto sum = [](const Trial& trial) {
    return std::accumulate(trial.point.begin(), trial.point.end(), 0.0) /
           std::sqrt(static_cast<double>(trial.point.size()));
  };
  const auto noise = [](const Trial& trial) {
    return RandomStream(trial.seed, StreamId::motion, 0).normal();
  };
  return {
      {"one side of a plane, 2 numbers", 2, below(4.265), [=](const Trial& t) { return sum(t) - 4.265; }},
      {"one side of a plane, 8 numbers", 8, below(4.265), [=](const Trial& t) { return sum(t) - 4.265; }},
      {"both sides", 3, 2 * below(4.4), [](const Trial& t) { return std::abs(t.point[0]) - 4.4; }},
      {"a corner", 2, below(2.5) * below(2.8),
       [](const Trial& t) { return std::min(t.point[0] - 2.5, t.point[1] - 2.8); }},
      {"outside of a circle", 2, 1e-3,
       [](const Trial& t) { return std::hypot(t.point[0], t.point[1]) - std::sqrt(2 * std::log(1e3)); }},
      {"with noise", 2, below(4.0 / std::sqrt(1.25)),
       [=](const Trial& t) { return t.point[0] + 0.5 * noise(t) - 4.0; }},
      {"without a slope", 1, below(2.0),
       [](const Trial& t) { return t.point[0] > 2.0 ? 1.0 : -std::numeric_limits<double>::infinity(); }},
      {"frequent", 4, below(0.5), [=](const Trial& t) { return sum(t) - 0.5; }},
      {"only noise", 1, below(1.5), [=](const Trial& t) { return noise(t) - 1.5; }},
  };
}

RareEvent estimate(const Known& known, int trials, std::uint64_t seed) {
  return estimate_rare_event(known.dimensions, trials, seed, [&](const std::vector<Trial>& flown) {
    std::vector<double> severities;
    for (const Trial& trial : flown) severities.push_back(known.severity(trial));
    return severities;
  });
}

TEST(RareEvent, ItsBoundsHoldAndTwoThousandTrialsFindItWithinAFactorOfTwo) {
  constexpr int repetitions = 100;
  for (const Known& known : known_events()) {
    int held = 0, close = 0;
    for (int i = 0; i < repetitions; ++i) {
      const RareEvent event = estimate(known, 2000, static_cast<std::uint64_t>(i) + 1);
      EXPECT_EQ(event.trials, 2000);
      held += event.bounds.low <= known.probability && known.probability <= event.bounds.high ? 1 : 0;
      const double ratio = event.probability / known.probability;
      close += ratio > 0.5 && ratio < 2 ? 1 : 0;
    }
    EXPECT_GE(held, 95) << known.name << " " << known.probability;
    EXPECT_GE(close, 95) << known.name << " " << known.probability;
  }
}

TEST(RareEvent, TheLowerBoundOfAFrequentEventIsRarelyAboveIt) {
  const Known known = {"frequent", 1, below(-1.645), [](const Trial& t) { return t.point[0] + 1.645; }};
  constexpr int repetitions = 2000;
  int above = 0;
  for (int i = 0; i < repetitions; ++i)
    above += estimate(known, 200, static_cast<std::uint64_t>(i) + 1).bounds.low > known.probability ? 1 : 0;
  EXPECT_LE(above, 22) << "0.5 % are meant";
}

TEST(RareEvent, ItIsTheSameEachTimeAndHasTheBoundOfTheTrueTrialsIfItIsNotSeen) {
  const Known known = known_events()[0];
  const RareEvent first = estimate(known, 1000, 7), again = estimate(known, 1000, 7);
  EXPECT_EQ(first.probability, again.probability);
  EXPECT_EQ(first.bounds.high, again.bounds.high);
  EXPECT_GT(first.seen, 100);

  const RareEvent never = estimate({"never", 2, 0.0, [](const Trial&) { return -1.0; }}, 1000, 7);
  EXPECT_EQ(never.probability, 0.0);
  EXPECT_EQ(never.seen, 0);
  EXPECT_GE(never.bounds.high, clopper_pearson(0, 200).high);  // of as many true trials at most
  EXPECT_LT(never.bounds.high, 0.05);
}

TEST(NormalMixture, HasTheDensityThatItDrawsFrom) {
  // The mean weight phi / q of its own points is 1, for any mixture that is wide enough.
  std::vector<std::vector<double>> points;
  for (std::uint64_t i = 0; i < 200; ++i) {
    RandomStream random(i, StreamId::motion, 0);
    const double side = i % 2 == 0 ? 1.5 : -1.5;
    points.push_back({side + random.normal(), side + random.normal(), random.normal()});
  }
  const NormalMixture mixture(points, std::vector<double>(points.size(), 1.0));
  double sum = 0.0;
  constexpr int n = 40'000;
  for (std::uint64_t i = 0; i < n; ++i) sum += std::exp(-mixture.log_ratio(mixture.draw(i)));
  EXPECT_NEAR(sum / n, 1.0, 0.05);
}

}  // namespace
}  // namespace sightline
