#include "sightline/campaign/runs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sightline/campaign/table.hpp"
#include "tests/support/command.hpp"
#include "tests/support/small_campaign.hpp"

namespace sightline {
namespace {

constexpr int runs_flown = 20;

CampaignTable flown_runs() {
  const Scenario scenario = small_campaign();
  const auto file = test::fresh_folder() / "runs.sqlite";
  RunTable table(file, scenario, *scenario.campaign, 9);
  fly_campaign(scenario, *scenario.campaign, {.runs = runs_flown, .seed = 9, .threads = 2},
               [&](const RunDraw& run, const RunResult& result) { table.add(run, result); });
  table.finish();
  return {scenario.name, file};
}

TEST(Runs, EachHasOneOutcomeAndAPlaceInTheHistogram) {
  Runs runs(flown_runs());
  std::int64_t all = 0;
  for (int i = 0; i < outcome_count; ++i) all += runs.count(static_cast<Outcome>(i));
  EXPECT_EQ(all, runs_flown);
  const double low = runs.quantile("energy", 0.0), high = runs.quantile("energy", 1.0);
  const std::vector<double> bins = runs.histogram("energy", low, high, 7);
  EXPECT_EQ(std::accumulate(bins.begin(), bins.end(), 0.0), runs_flown);
}

TEST(Runs, AQuantileIsOneOfTheValues) {
  Runs runs(flown_runs());
  std::vector<double> values = runs.values("energy");
  ASSERT_EQ(values.size(), static_cast<std::size_t>(runs_flown));
  std::sort(values.begin(), values.end());
  EXPECT_EQ(runs.quantile("energy", 0.0), values.front());
  EXPECT_EQ(runs.quantile("energy", 0.5), values[runs_flown / 2 - 1]);
  EXPECT_EQ(runs.quantile("energy", 1.0), values.back());
  EXPECT_TRUE(std::isnan(runs.quantile("NULL", 0.5)));
}

}  // namespace
}  // namespace sightline
