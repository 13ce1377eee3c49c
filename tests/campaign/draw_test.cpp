#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "sightline/analysis.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

constexpr int many = 20'000;

std::vector<double> drawn(const Distribution& distribution, int count = many) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    RandomStream random(5, StreamId::draw, i);
    values.push_back(draw(distribution, random));
  }
  return values;
}

double share(const std::vector<double>& values, auto&& holds) {
  return static_cast<double>(std::count_if(values.begin(), values.end(), holds)) /
         static_cast<double>(values.size());
}

/// Five standard deviations of a share.
double chance_of(double p) { return 5 * std::sqrt(p * (1 - p) / many); }

TEST(Draw, UniformNumbersStayInTheirRangeAndFillItEvenly) {
  const std::vector<double> values = drawn({.values = {-2.0, 3.0}});
  for (const double v : values) EXPECT_TRUE(v >= -2.0 && v <= 3.0);
  for (int tenth = 0; tenth < 10; ++tenth) {
    const double low = -2.0 + 0.5 * tenth;
    EXPECT_NEAR(share(values, [&](double v) { return v >= low && v < low + 0.5; }), 0.1, chance_of(0.1));
  }
}

TEST(Draw, NormalNumbersHaveTheirMeanAndDeviation) {
  const std::vector<double> values = drawn({.kind = Distribution::Kind::normal, .values = {1.0, 0.5}});
  double sum = 0, squares = 0;
  for (const double v : values) sum += v - 1.0, squares += (v - 1.0) * (v - 1.0);
  EXPECT_NEAR(sum / many, 0.0, 5 * 0.5 / std::sqrt(many));
  EXPECT_NEAR(squares / many, 0.25, 5 * 0.25 * std::sqrt(2.0 / many));
}

TEST(Draw, ChoicesComeInTheirSharesAndNothingElseDoes) {
  const std::vector<double> values = drawn({.kind = Distribution::Kind::choice,
                                            .values = {4.0, -1.0, 7.0, 9.0},
                                            .fractions = {0.2, 0.5, 0.3, 0.0}});
  EXPECT_NEAR(share(values, [](double v) { return v == 4.0; }), 0.2, chance_of(0.2));
  EXPECT_NEAR(share(values, [](double v) { return v == -1.0; }), 0.5, chance_of(0.5));
  EXPECT_NEAR(share(values, [](double v) { return v == 7.0; }), 0.3, chance_of(0.3));
  EXPECT_EQ(share(values, [](double v) { return v == 9.0; }), 0.0);
}

TEST(Draw, TheExactValueComesInItsShare) {
  const std::vector<double> values = drawn({.values = {-pi, pi}, .constant = pi, .fraction = 0.1});
  EXPECT_NEAR(share(values, [](double v) { return v == pi; }), 0.1, chance_of(0.1));
  EXPECT_NEAR(share(values, [](double v) { return v < 0; }), 0.45, chance_of(0.45));
}

CampaignPlan drawn_plan() {
  CampaignPlan some;
  some.starts = {{.agent = "a",
                  .around = "b",
                  .range = {.values = {0.3, 6.0}},
                  .bearing = {.values = {-1.0, 1.0}},
                  .height = {.values = {0.0, 2.0}},
                  .heading = {},
                  .velocity = Distribution{.values = {-1.0, 1.0}}}};
  some.draws = {{"x", {.values = {0.0, 1.0}}}};
  return some;
}

TEST(Draw, ARunIsMadeFromSeedAndIndexAlone) {
  for (const int index : {0, 1, 77, 999'999'999}) {
    const RunDraw a = draw_run(drawn_plan(), 3, index), b = draw_run(drawn_plan(), 3, index);
    EXPECT_EQ(a.index, index);
    EXPECT_EQ(a.seed, b.seed);
    EXPECT_EQ(a.values, b.values);
    EXPECT_EQ(a.values.size(), drawn_names(drawn_plan()).size());
    EXPECT_NE(draw_run(drawn_plan(), 4, index).values, a.values);
  }
}

TEST(Draw, NoTwoRunsShareASeedAndEverySeedIsANumberAScenarioTakes) {
  std::set<std::uint64_t> seeds;
  for (const std::uint64_t seed : {0ULL, 1ULL, ~0ULL}) {
    for (int i = 0; i < 5000; ++i) {
      const RunDraw run = draw_run({}, seed, i);
      EXPECT_TRUE(seeds.insert(run.seed).second);
      EXPECT_LT(run.seed, 1ULL << 53);
    }
  }
}

TEST(Draw, AnotherDrawInThePlanLeavesThoseBeforeItAsTheyWere) {
  CampaignPlan more = drawn_plan();
  more.draws.push_back({"y", {.values = {0.0, 1.0}}});
  for (int i = 0; i < 100; ++i) {
    std::vector<double> values = draw_run(more, 1, i).values;
    values.pop_back();
    EXPECT_EQ(values, draw_run(drawn_plan(), 1, i).values);
  }
}

TEST(Draw, ValuesOfOneRunDoNotGoTogether) {
  double mean = 0;
  for (int i = 0; i < many; ++i) {
    const RunDraw run = draw_run(drawn_plan(), 1, i);
    mean += run.values[3] * run.values[4] / many;  // v_f v_s, each of variance 1/3
  }
  EXPECT_NEAR(mean, 0.0, 5.0 / 3.0 / std::sqrt(many));
}

TEST(Draw, ARunAtANormalPointHasTheDistributionsOfThePlan) {
  CampaignPlan plan;
  plan.draws = {
      {.key = "a", .distribution = {.values = {-1.0, 3.0}}},
      {.key = "b", .distribution = {.kind = Distribution::Kind::normal, .values = {5.0, 2.0}}},
      {.key = "c",
       .distribution = {.kind = Distribution::Kind::choice, .values = {1.0, 2.0}, .fractions = {0.25, 0.75}}},
      {.key = "d", .distribution = {.values = {0.0, 1.0}, .constant = 9.0, .fraction = 0.3}}};
  const std::vector<double> middle(4), far = {-9.0, 1.5, -0.5, 9.0};
  EXPECT_EQ(run_at(plan, middle, 17, 3).values[0], 1.0);
  EXPECT_NEAR(run_at(plan, middle, 17, 3).values[1], 5.0, 1e-9);
  EXPECT_EQ(run_at(plan, middle, 17, 3).seed, 17U);
  EXPECT_EQ(run_at(plan, middle, 17, 3).index, 3);
  EXPECT_NEAR(run_at(plan, far, 1, 0).values[0], -1.0, 1e-9);
  EXPECT_NEAR(run_at(plan, far, 1, 0).values[1], 8.0, 1e-9);
  EXPECT_NEAR(run_at(plan, far, 1, 0).values[3], 1.0, 1e-9);

  // Kolmogorov and Smirnov's distance of two samples, one drawn and one at normal points.
  constexpr int n = 4000;
  std::vector<std::vector<double>> drawn(4), at_points(4);
  for (int i = 0; i < n; ++i) {
    RandomStream random(1, StreamId::motion, i);
    const std::vector<double> point = {random.normal(), random.normal(), random.normal(), random.normal()};
    const RunDraw a = draw_run(plan, 5, i), b = run_at(plan, point, 1, i);
    for (std::size_t v = 0; v < 4; ++v) drawn[v].push_back(a.values[v]), at_points[v].push_back(b.values[v]);
  }
  for (std::size_t v = 0; v < 4; ++v) {
    std::sort(drawn[v].begin(), drawn[v].end());
    std::sort(at_points[v].begin(), at_points[v].end());
    double distance = 0.0;
    for (const double value : drawn[v]) {
      const auto share = [&](const std::vector<double>& all) {
        return static_cast<double>(std::upper_bound(all.begin(), all.end(), value) - all.begin()) / n;
      };
      distance = std::max(distance, std::abs(share(drawn[v]) - share(at_points[v])));
    }
    EXPECT_LT(distance, 1.63 * std::sqrt(2.0 / n)) << v;  // 1 in 100 is farther apart
  }
}

}  // namespace
}  // namespace sightline
