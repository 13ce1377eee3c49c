#include "bridges/dds/fleet/finding.hpp"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

TEST(Finding, EachAspectHasAWordOfItsOwn) {
  std::set<std::string_view> words;
  for (int i = 0; i < aspects; ++i) words.insert(to_string(static_cast<Aspect>(i)));
  EXPECT_EQ(words.size(), static_cast<std::size_t>(aspects));
  EXPECT_EQ(to_string(Aspect::timing), "timing");  // the last one
  EXPECT_TRUE(keeps_grounded(Aspect::battery));
  EXPECT_FALSE(keeps_grounded(Aspect::timing));
}

TEST(Finding, TheWorstOfThemCounts) {
  std::vector<Finding> all;
  EXPECT_EQ(worst(all), Light::green);
  all.push_back({"a", Aspect::pilot, Light::unknown, ""});
  EXPECT_EQ(worst(all), Light::unknown);
  all.insert(all.begin(), {"a", Aspect::battery, Light::red, ""});
  EXPECT_EQ(worst(all), Light::red);
}

TEST(Finding, ATableHasAHeadingForEachRobotAndColoursWhereTheyAreAskedFor) {
  const std::vector<Finding> all = {{"uav0", Aspect::topics, Light::green, "all come"},
                                    {"uav1", Aspect::topics, Light::red, "none comes"},
                                    {"uav0", Aspect::battery, Light::unknown, "nobody says"},
                                    {"", Aspect::distance, Light::green, "far apart"},
                                    {"", Aspect::timing, Light::green, "in time"}};
  EXPECT_EQ(findings_table(all, false),
            "uav0\n"
            "  green    topics     all come\n"
            "  unknown  battery    nobody says\n"
            "uav1\n"
            "  red      topics     none comes\n"
            "fleet\n"
            "  green    distance   far apart\n"
            "this machine\n"
            "  green    timing     in time\n");
  EXPECT_NE(findings_table(all, true).find("\033[31mred    \033[0m  topics"), std::string::npos);
}

}  // namespace
}  // namespace sightline
