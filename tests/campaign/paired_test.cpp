#include "sightline/campaign/paired.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "sightline/campaign/runs.hpp"
#include "sightline/campaign/table.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

/// A table of runs with these energies; one that is not a number was lost.
CampaignTable table_of(const std::filesystem::path& folder, const std::string& name, int runs,
                       const std::function<double(int)>& energy) {
  Scenario scenario;
  scenario.name = name;
  scenario.team.add(Multirotor{}, {.name = "uav0"});
  const CampaignPlan plan;
  const CampaignTable table{name, folder / (name + ".sqlite")};
  RunTable rows(table.file, scenario, plan, 1);
  for (int i = 0; i < runs; ++i) {
    const double e = energy(i);
    const bool lost = std::isnan(e);
    rows.add(draw_run(plan, 1, i), {.outcome = lost ? Outcome::lost : Outcome::recovered,
                                    .energy = lost ? 9.0 : e,
                                    .robots = {{.energy = lost ? 9.0 : 0.5 * e}}});
  }
  rows.finish();
  return table;
}

TEST(MedianBounds, AreTheRanksOfTheBinomialDistribution) {
  const auto to = [](int n) {
    std::vector<double> values;
    for (int i = n; i > 0; --i) values.push_back(i);
    return values;
  };
  // Ranks of the sign test at 95 %, as tables have them.
  for (const auto& [n, low] :
       {std::pair{1, 1}, {5, 1}, {6, 1}, {9, 2}, {10, 2}, {20, 6}, {25, 8}, {100, 40}}) {
    const MedianBounds bounds = median_bounds(to(n));
    EXPECT_EQ(bounds.low, low) << n;
    EXPECT_EQ(bounds.high, n + 1 - low) << n;
    EXPECT_EQ(bounds.median, 0.5 * (n + 1)) << n;
  }
}

TEST(MedianBounds, HoldTheTrueMedianAsOftenAsTheySay) {
  Random random(1);
  int held = 0;
  constexpr int trials = 2000;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> values(51);
    for (double& v : values) v = std::exp(3.0 * uniform(random, -1, 1));  // the median is 1
    const MedianBounds bounds = median_bounds(values);
    EXPECT_LE(bounds.low, bounds.median);
    EXPECT_LE(bounds.median, bounds.high);
    held += bounds.low <= 1.0 && 1.0 <= bounds.high;
  }
  EXPECT_GE(held, trials * 94 / 100);
  EXPECT_LT(held, trials * 99 / 100);
}

TEST(Pairing, ComparesRunByRunWhereBothRecovered) {
  const auto folder = test::fresh_folder();
  const double lost = std::nan("");
  const CampaignTable a = table_of(folder, "a", 40, [&](int i) { return i < 10 ? lost : 1.0 + i; }),
                      b = table_of(folder, "b", 50,
                                   [&](int i) { return i % 4 == 0 ? lost : 2.0 * (1.0 + i); });
  const Pairing p = pair_runs(a, b, "energy");
  EXPECT_EQ(p.runs, 30 - 7);
  EXPECT_EQ(p.less, 0);
  EXPECT_EQ(p.more, p.runs);
  EXPECT_EQ(p.ratio.low, 2.0);
  EXPECT_EQ(p.ratio.median, 2.0);
  EXPECT_EQ(p.difference.median, 26.0);
  EXPECT_LT(p.difference.low, 26.0);
  const Pairing back = pair_runs(b, a, "energy");
  EXPECT_EQ(back.less, back.runs);
  EXPECT_EQ(back.difference.median, -26.0);
  EXPECT_EQ(pair_runs(a, b, "uav0.energy").difference.median, 13.0);
}

TEST(Pairing, LinesTellAllRobotsAndEach) {
  const auto folder = test::fresh_folder();
  const CampaignTable a = table_of(folder, "a", 30, [](int i) { return 1.0 + i; }),
                      b = table_of(folder, "b", 30, [](int i) { return 0.5 * (1.0 + i); });
  EXPECT_THAT(Runs(a).energies(), testing::ElementsAre("uav0.energy"));
  const auto lines = energy_lines(a, b);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0].value, "alone in 0 of 30 runs, the other alone in 0 (McNemar: p = 1)");
  EXPECT_EQ(lines[1].what, "energy");
  EXPECT_THAT(lines[1].value, HasSubstr("0.500 of it in the median (95 %: 0.500 to 0.500)"));
  EXPECT_THAT(lines[1].value,
              HasSubstr("less in 30 of 30 runs that both recovered (sign test: p = 1.9e-09)"));
  EXPECT_EQ(lines[2].what, "uav0.energy");
  EXPECT_EQ(energy_lines(a, a)[1].value, "the same in 30 runs that both recovered");
  const CampaignTable again = table_of(folder, "again", 30, [](int i) { return (1.0 + i) * (1 + 1e-15); });
  EXPECT_EQ(energy_lines(a, again)[1].value, "the same in 30 runs that both recovered") << "but for rounding";
  const CampaignTable none = table_of(folder, "none", 30, [](int) { return std::nan(""); });
  EXPECT_EQ(energy_lines(a, none)[1].value, "no run that both recovered");
}

TEST(Pairing, RunsThatOneAloneRecoveredAreCounted) {
  const auto folder = test::fresh_folder();
  const double lost = std::nan("");
  const CampaignTable a = table_of(folder, "a", 40, [&](int i) { return i < 10 ? lost : 1.0; }),
                      b = table_of(folder, "b", 50, [&](int i) { return i >= 8 && i < 12 ? lost : 1.0; });
  const OutcomePairing pairing = pair_outcomes(a, b);
  EXPECT_EQ(pairing.runs, 40);
  EXPECT_EQ(pairing.only_a, 2);
  EXPECT_EQ(pairing.only_b, 8);
}

}  // namespace
}  // namespace sightline
