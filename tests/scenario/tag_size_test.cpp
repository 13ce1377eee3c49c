#include "sightline/scenario/tag_size.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bridges/dds/fleet/finding.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Scenario kept_between(double d_min, double d_max) {
  return test::scenario_of(fmt::format(R"(
[agent.a]
robot = "multirotor"
start = {{ p = [0.0, 0.0, 1.0], heading = 0.0 }}
sensor = {{ pitch = 0.0 }}
[agent.a.camera]
[agent.b]
robot = "multirotor"
start = {{ p = [2.0, 0.0, 1.0], heading = 0.0 }}
[agent.b.tags]
[[couple]]
potential = {{ too_near = {{ d_min = {} }} }}
between = ["a", "b"]
felt_by = ["a"]
[[couple]]
potential = {{ too_far = {{ d_max = {} }} }}
between = ["a", "b"]
felt_by = ["a"]
)",
                                       d_min, d_max));
}

TEST(TagSize, NothingIsSaidOfTagsThatAreReadFromEverySide) {
  const TagSize judged = judge_tag_sizes(kept_between(1.0, 2.5));
  EXPECT_THAT(judged.warnings, IsEmpty());
  EXPECT_THAT(judged.refusals, IsEmpty());
}

TEST(TagSize, TagsThatAreSmallAtTheGreatestDistanceAreAWarning) {
  EXPECT_THAT(judge_tag_sizes(kept_between(1.0, 3.0)).warnings,
              ElementsAre(HasSubstr("13.9 px for the camera of a at d_max = 3 m, below 14.4 px")));
  EXPECT_THAT(judge_tag_sizes(kept_between(1.0, 4.0)).warnings,
              ElementsAre(HasSubstr("10.4 px for the camera of a at d_max = 4 m, below 10.6 px")));
  EXPECT_THAT(check_scenario(kept_between(1.0, 4.0)).warnings,
              Contains(HasSubstr("below 10.6 px it is not read")));
}

TEST(TagSize, TagsThatAreTooSmallEverywhereAreRefused) {
  EXPECT_THAT(
      judge_tag_sizes(kept_between(4.0, 5.0)).refusals,
      ElementsAre(HasSubstr("10.4 px for the camera of a at d_min = 4 m, expected at least 10.6 px")));
  EXPECT_THAT(check_scenario(kept_between(4.0, 5.0)).refusals,
              Contains(HasSubstr("expected at least 10.6 px")));
}

TEST(TagSize, BeforeAFlightEachDistanceAtWhichTagsAreTooSmallIsRed) {
  const std::vector<Finding> small = tag_findings(kept_between(1.0, 3.0));
  ASSERT_EQ(small.size(), 1u);
  EXPECT_EQ(small[0].light, Light::red);
  EXPECT_EQ(small[0].aspect, Aspect::tags);
  EXPECT_THAT(small[0].sentence, HasSubstr("at d_max = 3 m, below 14.4 px it is not read from every side"));
  EXPECT_THAT(tag_findings(kept_between(1.0, 4.0))[0].sentence, HasSubstr("below 10.6 px it is not read:"));
  const std::vector<Finding> large = tag_findings(kept_between(1.0, 2.5));
  ASSERT_EQ(large.size(), 1u);
  EXPECT_EQ(large[0].light, Light::green);
  EXPECT_THAT(large[0].sentence, HasSubstr("at d_max = 2.5 m, enough from every side"));
}

}  // namespace
}  // namespace sightline
