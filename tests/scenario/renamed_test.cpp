#include "sightline/scenario/renamed.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

constexpr std::string_view of_old_names = R"(# watches, like and paths in a comment stay
[log]
paths = 0.5   # between two predictions
[template.scout]
robot = "point_mass"
[agent."ä"]
like = "scout"
localized_by = "view"  # not "global"
'watches' = ["like"]
camera.tells = "pose"
[agent."b.c"]
inherits = "scout"
localization = "view"
[campaign]
start = [{ agent = "like", bearing = { exactly = 3.0, share = 0.1 } }]
[[campaign.draw]]
key = "log.paths"
choice = [1.0, 2.0]
shares = [0.5, 0.5]
[[couple]]
share = "not of a campaign"
)";

constexpr std::string_view of_present_names = R"(# watches, like and paths in a comment stay
[log]
prediction_period = 0.5   # between two predictions
[template.scout]
robot = "point_mass"
[agent."ä"]
inherits = "scout"
localization = "vision"  # not "global"
'observes' = ["like"]
camera.output = "pose"
[agent."b.c"]
inherits = "scout"
localization = "vision"
[campaign]
start = [{ agent = "like", bearing = { constant = 3.0, fraction = 0.1 } }]
[[campaign.draw]]
key = "log.paths"
choice = [1.0, 2.0]
fractions = [0.5, 0.5]
[[couple]]
share = "not of a campaign"
)";

TEST(Renamed, EveryOldNameIsReplacedWhereItStandsAndNothingElse) {
  const RenamedText renamed = with_present_names(of_old_names, "a.toml");
  EXPECT_EQ(renamed.text, of_present_names);
  ASSERT_EQ(renamed.changes.size(), 10u);
  EXPECT_EQ(renamed.changes.front(), "a.toml:3: log.paths is prediction_period now");
  EXPECT_EQ(renamed.changes[2], "a.toml:8: agent.ä.localized_by is localization now");
  EXPECT_EQ(renamed.changes[3], "a.toml:8: agent.ä.localized_by = \"view\" is \"vision\" now");
}

TEST(Renamed, ATextOfPresentNamesStaysByteForByte) {
  const RenamedText renamed = with_present_names(of_present_names, "a.toml");
  EXPECT_EQ(renamed.text, of_present_names);
  EXPECT_TRUE(renamed.changes.empty());
}

TEST(Renamed, TheFirstOldNameOfAFileIsRefusedByItsPresentOne) {
  EXPECT_EQ(
      refusal_of<ScenarioError>([] { (void)parse_scenario(std::string(of_old_names), "a.toml"); }),
      "a.toml:3: log.paths, expected the key prediction_period, its name since 0.2 (sightline check --fix "
      "rewrites a file)");
  EXPECT_EQ(
      refusal_of<ScenarioError>(
          [] { (void)parse_scenario("[agent.a]\nlocalization = \"view\"\n", "a.toml"); }),
      "a.toml:2: agent.a.localization = \"view\", expected \"vision\", its name since 0.2 (sightline check "
      "--fix rewrites a file)");
}

TEST(Renamed, AValueThatIsSetFromOutsideIsRefusedToo) {
  EXPECT_THAT(refusal_of<ScenarioError>([] {
                (void)parse_scenario("[agent.a]\nrobot = \"point_mass\"\n", "a.toml", built_in_registry(),
                                     {.files = {}, .set = {"agent.a.watches=[\"b\"]"}});
              }),
              testing::HasSubstr("agent.a.watches, expected the key observes"));
}

}  // namespace
}  // namespace sightline
