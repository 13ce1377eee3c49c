#include "sightline/scenario/starts.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Robots a and b, b where it is told, and more.
std::vector<std::string> start_warnings(const std::string& p, const std::string& more,
                                        const std::string& of_b = "") {
  return warnings_of_starts(parse_scenario(fmt::format(R"(
[agent.a]
robot = "multirotor"
start = {{ p = [0.0, 0.0, 1.0], heading = 0.0 }}
[agent.b]
robot = "multirotor"
start = {{ p = {}, heading = 0.0 }}
{}
{}
)",
                                                       p, of_b, more),
                                           "starts.toml"));
}
constexpr const char* safety =
    "[safety]\nbarrier = \"on\"\nfloor = 0.3\nceiling = 3.0\nworld = 10.0\nd_hard = 0.6\n";

TEST(Starts, BelowTheFloorAboveTheCeilingAndOutsideTheWorldAreTold) {
  EXPECT_THAT(start_warnings("[2.0, 0.0, 0.1]", safety),
              ElementsAre(HasSubstr("0.2 m below the floor = 0.3 m")));
  EXPECT_THAT(start_warnings("[2.0, 0.0, 3.5]", safety),
              ElementsAre(HasSubstr("0.5 m above the ceiling = 3 m")));
  EXPECT_THAT(start_warnings("[0.0, -12.0, 1.0]", safety),
              ElementsAre(HasSubstr("2 m outside the world of 10 m")));
  EXPECT_THAT(start_warnings("[2.0, 0.0, 1.0]", safety), IsEmpty());
}

TEST(Starts, WithinTheHardDistanceAreToldAndOfABodyWithItsOwnItCounts) {
  EXPECT_THAT(start_warnings("[0.5, 0.0, 1.0]", safety),
              ElementsAre(HasSubstr("nearer than d_hard = 0.6 m")));
  const std::string wall = "[obstacle.wall]\np = [1.5, 0.0, 1.0]\nd_hard = 2.0\n";
  EXPECT_THAT(start_warnings("[4.0, 0.0, 1.0]", safety + wall),
              ElementsAre(HasSubstr("a starts 1.5 m from the start of wall")));
}

TEST(Starts, ABodyThatAnEventAddsWhereAnotherStartsIsTold) {
  const std::string join = "[[event]]\nname = \"join\"\nat = 3.0\nadd = \"b\"\n";
  EXPECT_THAT(start_warnings("[0.0, 0.0, 1.0]", join, "present = false"),
              ElementsAre(HasSubstr("b joins by the event \"join\" 0 m from the start of a")));
  EXPECT_THAT(start_warnings("[0.0, 0.0, 1.0]", "", "present = false"), IsEmpty()) << "it is never there";
  EXPECT_THAT(start_warnings("[2.0, 0.0, 1.0]", join, "present = false"), IsEmpty());
}

TEST(Starts, TwoRobotsInOnePlaceAreRefusedUnlessACampaignDrawsThem) {
  EXPECT_EQ(refusal_of<ScenarioError>([] { (void)start_warnings("[0.0, 0.0, 1.0]", ""); }),
            "starts.toml:7: agent.b.start.p = [0, 0, 1], expected a place of its own, a starts there");
}

}  // namespace
}  // namespace sightline
