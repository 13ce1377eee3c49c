#include "sightline/analysis/potential_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/paper_team.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

const VerdictOptions few_samples = {.samples = 2000};

Scenario twice_the_paper() {
  Scenario scenario;
  scenario.name = "a <b> & c";
  scenario.team = paper::team(paper::Variant::masked);
  scenario.team.couple(0.7 * SensorCone{}, Between{paper::uav1, paper::uav0});
  scenario.team.couple(0.4 * KeepOut{.d_min = 2.0}, Between{paper::uav1, paper::uav0});
  return scenario;
}

TEST(JudgeCouplings, JudgesEqualPotentialsOnceAndOthersEach) {
  const auto judged = judge_couplings(twice_the_paper().team, {}, few_samples);
  ASSERT_EQ(judged.size(), 5u);
  EXPECT_EQ(judged[3].same_as, 0u);
  for (const std::size_t i : {0u, 1u, 2u, 4u}) {
    EXPECT_FALSE(judged[i].same_as) << i;
    EXPECT_FALSE(judged[i].verdict.words.empty()) << i;
  }
}

TEST(JudgeCouplings, LooksAtTheOneThatIsAskedFor) {
  const auto judged = judge_couplings(twice_the_paper().team, 4, few_samples);
  ASSERT_EQ(judged.size(), 1u);
  EXPECT_EQ(judged[0].coupling, 4u);
  EXPECT_EQ(judged[0].verdict.name, "keep_out");
}

TEST(VerdictJson, HasAnEntryForEachCouplingInOrder) {
  const Scenario scenario = twice_the_paper();
  const auto json =
      nlohmann::json::parse(verdict_json(scenario, judge_couplings(scenario.team, {}, few_samples)));
  EXPECT_EQ(json.at("scenario"), scenario.name);
  ASSERT_EQ(json.at("couplings").size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(json.at("couplings")[i].at("couple"), i);
  EXPECT_EQ(json.at("couplings")[3].at("same_as"), 0);
  EXPECT_EQ(json.at("couplings")[3].at("weight"), 0.7);
  EXPECT_EQ(json.at("couplings")[1].at("verdict").at("potential"), "cohesion");
}

TEST(PotentialPage, IsOneFileWithASectionForEach) {
  const Scenario scenario = twice_the_paper();
  const std::string page = potential_html(scenario, judge_couplings(scenario.team, {}, few_samples));
  EXPECT_THAT(page, HasSubstr("a &lt;b&gt; &amp; c"));
  EXPECT_THAT(page, HasSubstr("couple[4] keep_out of uav1 and uav0"));
  EXPECT_THAT(page, HasSubstr("The same potential as couple[0]"));
  EXPECT_THAT(page, HasSubstr("</html>"));
  for (const char* outside : {"<script src", "<link", " src=", "href='http", "href=\"http"}) {
    EXPECT_THAT(page, Not(HasSubstr(outside)));
  }
}

}  // namespace
}  // namespace sightline
