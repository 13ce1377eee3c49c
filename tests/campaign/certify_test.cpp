#include "sightline/campaign/certify.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/campaign/table.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/small_campaign.hpp"

namespace sightline {
namespace {

/// The scenario with its starts far off the target's axis, so that many runs lose the view.
Scenario losing_campaign() {
  Scenario scenario = small_campaign();
  scenario.campaign->duration = 3.0;
  scenario.campaign->view_within = 0.5;
  return scenario;
}

constexpr double spread_x = 0.1, spread_y = 0.2413;  // [m]

/// Two robots at rest: the view is lost where the drawn place of one is outside of the other's
/// cone.
Scenario resting_pair() {
  return test::scenario_of(fmt::format(R"(
[horizon]
duration = 0.5
stages = 5
period = 0.05
[agent.uav0]
robot = "multirotor"
sensor = {{ pitch = 0.0, offset = 0.0 }}
start = {{ p = [0.0, 0.0, 1.0] }}
R = [1.0, 1.0, 1.0, 1.0]
[agent.uav1]
robot = "multirotor"
start = {{ p = [2.0, 0.0, 1.0] }}
R = [1.0, 1.0, 1.0, 1.0]
[[couple]]
potential = {{ bearing = {{ alpha = 0.5 }} }}
between = ["uav0", "uav1"]
felt_by = ["uav0"]
weight = 0.0
[campaign]
duration = 1.0
view_within = 0.1
[[campaign.draw]]
key = "agent.uav1.start.p[0]"
normal = [2.0, {}]
[[campaign.draw]]
key = "agent.uav1.start.p[1]"
normal = [0.0, {}]
)",
                                       spread_x, spread_y));
}

Certificate certified(const Scenario& scenario, const CampaignOptions& options, int rare_runs) {
  const CampaignPlan& plan = *scenario.campaign;
  const auto file = test::fresh_folder() / "campaign.sqlite";
  {
    RunTable table(file, scenario, plan, options.seed);
    fly_campaign(scenario, plan, options,
                 [&](const RunDraw& run, const RunResult& result) { table.add(run, result); });
    table.finish();
  }
  return certify(scenario, plan, {"small", file}, options, rare_runs);
}

TEST(Margins, AreNegativeInTheRunsThatTheOtherFiguresBlame) {
  const Scenario scenario = losing_campaign();
  const CampaignPlan& plan = *scenario.campaign;
  int lost = 0, kept = 0;
  fly_campaign(
      scenario, plan, {.runs = 60, .seed = 3, .threads = 1}, [&](const RunDraw&, const RunResult& run) {
        if (run.longest_out_of_view > view_lost_after + 0.011) {
          EXPECT_LT(run.view_margin, 0);
        }
        if (run.time_to_first_view <= plan.view_within && run.longest_out_of_view < view_lost_after - 0.011) {
          EXPECT_FALSE(run.view_margin < 0);
        }
        (run.view_margin < 0 ? lost : kept) += 1;
        EXPECT_EQ(run.distance_margin < 0, run.outcome == Outcome::too_close);
        EXPECT_FALSE(run.landed);
      });
  EXPECT_GT(lost, 0);
  EXPECT_GT(kept, 0);
}

TEST(Certify, BoundsAgreeWithIndependentRunsAndAreTheSameEachTime) {
  const Scenario scenario = losing_campaign();
  const CampaignOptions options{.runs = 150, .seed = 3, .threads = 2};
  const Certificate certificate = certified(scenario, options, 200);
  ASSERT_EQ(certificate.events.size(), 3U);
  const CertifiedEvent& view = certificate.events[0];
  ASSERT_TRUE(view.rare);
  EXPECT_GT(view.seen, 0);
  EXPECT_LE(view.rare->bounds.low, view.bounds.high);
  EXPECT_GE(view.rare->bounds.high, view.bounds.low);
  EXPECT_EQ(view.rare->trials, 200);
  EXPECT_FALSE(certificate.events[2].rare) << "a landing has no margin";
  EXPECT_EQ(certificate.events[2].seen, 0);

  CampaignOptions alone = options;
  alone.threads = 1;
  const Certificate again = certified(scenario, alone, 200);
  EXPECT_EQ(certificate_json(certificate), certificate_json(again));
  const auto json = nlohmann::json::parse(certificate_json(certificate));
  EXPECT_EQ(json.at("scenario"), scenario.name);
  EXPECT_EQ(json.at("view_within"), 0.5);
  EXPECT_EQ(json.at("events")[0].at("independent").at("seen"), view.seen);
  EXPECT_EQ(json.at("events")[0].at("importance_sampling").at("high"), view.rare->bounds.high);
  EXPECT_NE(certificate_html(certificate).find("view lost for more than 0.5 s"), std::string::npos);
}

TEST(Certify, FindsTheKnownProbabilityOfOneIn100000ByTwoThousandRuns) {
  const Scenario scenario = resting_pair();
  // |y| > x tan(alpha): two sides of a plane each.
  const double slope = std::tan(0.5), z = 2.0 * slope / std::hypot(spread_y, slope * spread_x),
               probability = std::erfc(z / std::sqrt(2.0));
  EXPECT_NEAR(probability, 1e-5, 1e-6);
  const int repetitions = runs(100, 25);
  int held = 0, close = 0;
  for (int i = 0; i < repetitions; ++i) {
    const CampaignOptions options{.runs = 20, .seed = static_cast<std::uint64_t>(i) + 1, .threads = 1};
    const CertifiedEvent view = certified(scenario, options, 2000).events[0];
    ASSERT_TRUE(view.rare);
    held += view.rare->bounds.low <= probability && probability <= view.rare->bounds.high ? 1 : 0;
    const double ratio = view.rare->probability / probability;
    close += ratio > 0.5 && ratio < 2 ? 1 : 0;
  }
  EXPECT_GE(100 * held, 95 * repetitions);
  EXPECT_GE(100 * close, 95 * repetitions);
}

}  // namespace
}  // namespace sightline
