#include "sightline/analysis/verdict_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

Verdict harmless() {
  Verdict v;
  v.has_view = v.sees_heading = true;
  v.outside = 0.5;
  v.of_step = v.of_limit = HalfAngle{0.4, 0.6};
  return v;
}

TEST(Describe, AHarmlessVerdictWarnsOfNothing) {
  Verdict v = harmless();
  describe(v);
  EXPECT_FALSE(v.words.empty());
  EXPECT_TRUE(v.warnings.empty());
  EXPECT_THAT(v.words, Contains(HasSubstr("0.400 to 0.600 rad")));
}

TEST(Describe, EachWarningStandsAmongTheWords) {
  Verdict v = harmless();
  v.of_step = HalfAngle{0.3, 0.3};
  v.step_disagrees = 0.1, v.bias = 0.5, v.bias_worst = 1.0, v.flat_in_yaw_behind = 0.9, v.turns_away = 0.3;
  v.flat_beyond = 3.0, v.flat_within = 0.2, v.traps = {{{1, 2, 3}, 0.5}}, v.traps_in_yaw = 0.5,
  v.curvature_worst = 1e6;
  describe(v);
  EXPECT_EQ(v.warnings.size(), 10u);
  for (const std::string& warning : v.warnings) EXPECT_THAT(v.words, Contains(warning));
}

TEST(Describe, SaysNothingOfYawWhereTheHeadingDoesNotMatter) {
  Verdict v = harmless();
  v.has_view = v.sees_heading = false;
  v.of_step = v.of_limit = {};
  describe(v);
  EXPECT_THAT(v.words, Not(Contains(HasSubstr("dpsi"))));
  EXPECT_THAT(v.words, Contains(HasSubstr("does not depend on the heading")));
}

}  // namespace
}  // namespace sightline
