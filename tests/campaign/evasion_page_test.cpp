#include "sightline/campaign/evasion_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/analysis.hpp"

namespace sightline {
namespace {

Scenario shipped(const std::string& name) {
  return read_scenario(std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "scenarios" / (name + ".toml"));
}

CampaignPlan plan_of(const Scenario& scenario, double duration) {
  CampaignPlan plan = *scenario.campaign;
  plan.duration = duration;
  return plan;
}

TEST(EvasionPage, TheRunsFlownOnceMoreAreTheCampaigns) {
  const Scenario scenario = shipped("paper_7_3");
  const CampaignPlan plan = plan_of(scenario, 30.0);
  const EvasionRuns flown = evasion_runs(scenario, plan, 5, 4);
  ASSERT_EQ(flown.runs.size(), 4U);
  const int handed =
      fly_campaign(scenario, plan, {.runs = 4, .seed = 5}, [&](const RunDraw& run, const RunResult& result) {
        const EvasionRow& row = flown.runs[static_cast<std::size_t>(run.index)].row();
        // That of the campaign is of the motion between the samples too.
        const double sampled = std::min(row.min_obstacle, row.min_target);
        EXPECT_LE(result.min_distance, sampled);
        EXPECT_GT(result.min_distance, sampled - 0.005);
        EXPECT_EQ(result.time_to_first_view, row.first_view);
      });
  EXPECT_EQ(handed, 4);
}

TEST(EvasionPage, ShowsTheTableOfAllScenariosAndTheFiguresOfEach) {
  const Scenario ours = shipped("paper_7_3_ours"), paper = shipped("paper_7_3");
  const CampaignPlan plan = plan_of(ours, 16.0);
  const std::vector flown = {evasion_runs(ours, plan, 1, 2), evasion_runs(paper, plan, 1, 2)};
  EXPECT_THAT(
      evasion_text(*plan.evasion, flown),
      testing::AllOf(testing::HasSubstr("published        0.976   0.950"),
                     testing::HasSubstr("paper_7_3_ours"), testing::HasSubstr("max alpha_t,ns [rad]")));
  const std::string html = evasion_html(*plan.evasion, flown);
  const auto count = [&](std::string_view what) {
    std::size_t n = 0;
    for (std::size_t at = html.find(what); at != std::string::npos; at = html.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<script type=\"application/json\">"), 2U * 5U);
  EXPECT_EQ(count("<h2>paper_7_3: paths from above (Fig. 26)"), 1U);
  EXPECT_EQ(count("<td>0.601</td>"), 1U);
  EXPECT_EQ(count("<tr>"), count("</tr>"));
}

TEST(EvasionPage, NoMoreThanTenRunsAreShown) {
  const Scenario scenario = shipped("paper_7_3_ours");
  EXPECT_EQ(evasion_runs(scenario, plan_of(scenario, 0.1), 1, 1000).runs.size(), 10U);
}

}  // namespace
}  // namespace sightline
