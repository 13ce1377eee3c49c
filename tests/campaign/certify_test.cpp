#include "sightline/campaign/certify.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/campaign/table.hpp"
#include "tests/support/folder.hpp"
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
  const CampaignPlan& plan = *scenario.campaign;
  const auto file = test::fresh_folder() / "campaign.sqlite";
  const CampaignOptions options{.runs = 150, .seed = 3, .threads = 2};
  {
    RunTable table(file, scenario, plan, options.seed);
    fly_campaign(scenario, plan, options,
                 [&](const RunDraw& run, const RunResult& result) { table.add(run, result); });
    table.finish();
  }
  const Certificate certificate = certify(scenario, plan, {"small", file}, options, 200);
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
  const Certificate again = certify(scenario, plan, {"small", file}, alone, 200);
  EXPECT_EQ(certificate_json(certificate), certificate_json(again));
  const auto json = nlohmann::json::parse(certificate_json(certificate));
  EXPECT_EQ(json.at("events")[0].at("independent").at("seen"), view.seen);
  EXPECT_EQ(json.at("events")[0].at("importance_sampling").at("high"), view.rare->bounds.high);
  EXPECT_NE(certificate_html(certificate).find("view lost for more than 0.5 s"), std::string::npos);
}

}  // namespace
}  // namespace sightline
