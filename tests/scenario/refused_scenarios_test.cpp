#include "tests/support/refused_scenarios.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(RefusedScenarios, EachIsRefusedWithItsSentenceAndAFormulaAtItsToken) {
  const std::vector<test::RefusedScenario> cases = test::refused_scenarios();
  EXPECT_GE(cases.size(), 270U);
  for (const test::RefusedScenario& c : cases) {
    SCOPED_TRACE(c.table + ": " + c.name);
    EXPECT_THAT(c.sentence, HasSubstr("expected"));
    if (c.table == "formulas") {
      EXPECT_TRUE(std::regex_search(c.sentence, std::regex("^[0-9]+:[0-9]+: "))) << c.sentence;
    }
    const std::string file = c.name + ".toml";
    EXPECT_EQ(refusal_of<ScenarioError>([&] {
                const Scenario flown = parse_scenario(c.text, file);
                if (flown.campaign_refusal) throw ScenarioError(*flown.campaign_refusal);
              }),
              file + ":" + c.sentence);
  }
}

TEST(RefusedScenarios, ACaseIsItsOwnLineAndTheSharedOnesAroundItsOwn) {
  std::vector<test::RefusedScenario> cases;
  test::add_refused("t",
                    "# about\n\n## one\na = 1\n...\n\nb = 2\n### first: 3: wrong\nc = 3\nd = 4\n"
                    "### second: 2: missing\n\n## two\n...\n### third: 1: \"é\": wrong\ne = 5\n",
                    cases);
  ASSERT_EQ(cases.size(), 3U);
  EXPECT_EQ(cases[0].text, "### first: 3: wrong\na = 1\nc = 3\nd = 4\n\nb = 2\n");
  EXPECT_EQ(cases[1].text, "### second: 2: missing\na = 1\n\nb = 2\n");
  EXPECT_EQ(cases[2].text, "### third: 1: \"é\": wrong\ne = 5\n");
  EXPECT_EQ(cases[2].table, "t");
  EXPECT_EQ(cases[2].name, "third");
  EXPECT_EQ(cases[2].sentence, "1: \"é\": wrong");
}

TEST(RefusedScenarios, ACaseThatWouldBeLostIsAnError) {
  std::vector<test::RefusedScenario> cases;
  const auto refusal = [&cases](const char* table) {
    return refusal_of([&] { test::add_refused("t", table, cases); });
  };
  EXPECT_EQ(refusal("## one\n...\n### first: 1: wrong\n"), "");
  EXPECT_EQ(refusal("## two\n...\n### first: 2: wrong\n"),
            "t: ### first: 2: wrong, expected a name that no other case has");
  EXPECT_EQ(refusal("## two\n...\n### second:\na = 1\n"), "t: ### second:, expected ### NAME: SENTENCE");
  EXPECT_EQ(refusal("## two\n...\n### second: \n"), "t: ### second: , expected ### NAME: SENTENCE");
  EXPECT_EQ(refusal("## two\n...\n### : 2: wrong\n"), "t: ### : 2: wrong, expected ### NAME: SENTENCE");
  EXPECT_EQ(refusal("### second: 2: wrong\n## two\n...\n"),
            "t: the first case, expected a section before it");
  EXPECT_EQ(refusal("## two\na = 1\n### second: 2: wrong\n"),
            "t: ## two, expected one line ... for what is a case's own");
  EXPECT_EQ(refusal("## two\n...\n...\n### second: 2: wrong\n"),
            "t: ## two, expected one line ... for what is a case's own");
  const std::string hidden = ", expected no comments: a case would be hidden in one";
  EXPECT_EQ(refusal("## two\n...\n###second: 2: wrong\n### third: 2: wrong\n"), "t: ## two" + hidden);
  EXPECT_EQ(refusal("## two\n...\n### second: 2: wrong\n#### third: 2: wrong\n"),
            "t: ### second: 2: wrong" + hidden);
  EXPECT_EQ(refusal("## two\n...\n## three\n...\n### second: 2: wrong\n"), "t: ## two, expected cases");
}

}  // namespace
}  // namespace sightline
