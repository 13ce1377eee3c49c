#include "sightline/analysis/view_band.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/analysis.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::string_view observer_text = R"(
[agent.a]
robot = "multirotor"
start = { p = [2.0, 0.0, 1.5], heading = 3.1 }
sensor = { pitch = 0.5, offset = 0.17 }
camera = {}
[agent.b]
robot = "multirotor"
start = { p = [-2.0, 0.0, 1.5], heading = 0.0 }
sensor = { pitch = 0.5, offset = 0.17 }
camera = {}
[agent.c]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }
reference = { circle = { centre = [0.0, 0.0, 1.0], radius = 1.0, rate = 0.5 } }
Q = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]
tags = {}
)";
constexpr std::string_view view_text = R"(
[[couple]]
potential = { bearing = {} }
between = ["a", "c"]
felt_by = ["a"]
[[couple]]
potential = { bearing = {} }
between = ["b", "c"]
felt_by = ["b"]
[[couple]]
potential = { too_near = {} }
between = ["a", "b"]
)";

TEST(ViewBand, EachCameraThatLooksAtTagsHasOneAndEqualOnesAreFlownOnce) {
  const Scenario scenario = test::scenario_of(std::string(observer_text) + std::string(view_text));
  const std::vector<ViewBand> bands = view_bands(scenario, 1);
  ASSERT_EQ(bands.size(), 2U);
  EXPECT_NEAR(bands[0].speed, 0.5, 0.01);
  EXPECT_FALSE(bands[0].same_as);
  EXPECT_EQ(bands[1].same_as, 0U);
  EXPECT_EQ(bands[1].rows.size(), bands[0].rows.size());
  ASSERT_TRUE(bands[0].serves);
  EXPECT_GE(bands[0].serves->low, 0.75);
  EXPECT_LE(bands[0].serves->low, 1.25);
  EXPECT_GE(bands[0].serves->high, 1.75);
  EXPECT_LE(bands[0].serves->high, 2.5);
  const std::string text = to_string(bands[0], scenario.team);
  EXPECT_THAT(text, HasSubstr("a sees the tags of c, which moves at up to 0.5 m/s\n"));
  EXPECT_THAT(text, HasSubstr("it is served best from "));
}

TEST(ViewBand, EachSensorThatLooksAtATargetHasItsOwn) {
  std::string text(observer_text);
  text += "[agent.a.sensors.left]\nyaw = 0.3\ncamera = { height = 480, width = 640 }\n";
  for (const char* sensor : {"", "sensor = \"left\"\n"})
    text += std::string(
                "[[couple]]\npotential = { bearing = {} }\nbetween = [\"a\", \"c\"]\nfelt_by = [\"a\"]\n") +
            sensor;
  const Scenario scenario = test::scenario_of(text);
  const std::vector<ViewBand> bands = view_bands(scenario, 1);
  ASSERT_EQ(bands.size(), 2U);
  EXPECT_FALSE(bands[1].same_as);
  EXPECT_THAT(to_string(bands[0], scenario.team), HasSubstr("a sees the tags of c"));
  EXPECT_THAT(to_string(bands[1], scenario.team), HasSubstr("a left sees the tags of c"));
  EXPECT_GT(bands[1].rows.back().distance, bands[0].rows.back().distance) << "it has more pixels";
}

TEST(ViewBand, TagsThatAreTooSmallServeNowhere) {
  std::string text = std::string(observer_text) + std::string(view_text);
  text.replace(text.find("tags = {}"), 9, "tags = { size = 0.01 }");
  const Scenario scenario = test::scenario_of(text);
  const std::vector<ViewBand> bands = view_bands(scenario, 1);
  ASSERT_FALSE(bands.empty());
  EXPECT_FALSE(bands[0].serves);
}

TEST(ViewBand, OfRobotsThatTurnByAChoiceItIsSaidWhatTheyCannotKnow) {
  const std::string text(observer_text);
  const std::string best =
      "[[shape]]\nname = \"who\"\nbest = { target = [\"c\"], observers = [\"a\", \"b\"] }\n"
      "potential = { bearing = {} }\n";
  EXPECT_THAT(unobservable_robots(test::scenario_of(text + best)), IsEmpty());
  // So far away that nobody sees anybody.
  std::string far = text;
  far.replace(far.find("p = [2.0"), 8, "p = [9.0");
  const Scenario scenario = test::scenario_of(far + best);
  const auto unobservable = HasSubstr("the position and heading of a are unobservable: no path of views");
  EXPECT_THAT(unobservable_robots(scenario), testing::ElementsAre(unobservable));
  EXPECT_THAT(preflight(scenario).warnings, Contains(unobservable));
}

TEST(ViewBand, WhoIsLocalizedByViewKnowsItsPlaceByTagsThatAreThere) {
  std::string text(observer_text);
  text.replace(text.find("camera = {}"), 11, "camera = {}\nlocalization = \"vision\"");
  EXPECT_THAT(unobservable_robots(test::scenario_of(text + std::string(view_text))), IsEmpty());
  text.replace(text.find("tags = {}"), 9, "tags = {}\npresent = false");
  const std::string later = "[[event]]\nat = 5.0\nadd = \"c\"\n";
  EXPECT_THAT(unobservable_robots(test::scenario_of(text + std::string(view_text) + later)),
              testing::ElementsAre(HasSubstr("the position and heading of a are unobservable")));
}

}  // namespace
}  // namespace sightline
