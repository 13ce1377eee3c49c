#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/analysis.hpp"

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

Preflight of(const std::string& limit, double duration, const std::string& more = "") {
  return preflight(parse_scenario(fmt::format(R"(
[agent.a]
robot = "multirotor"
start = {{ p = [-10.0, 0.0, 1.0], heading = 0.0 }}
sensor = {{ pitch = 0.3 }}
[agent.b]
robot = "multirotor"
start = {{ p = [-9.0, 0.0, 1.0], heading = 0.0 }}
[[couple]]
name = "limit"
between = ["a", "b"]
[couple.potential.region]
inside = {}
slope = {{ softplus = {{}} }}
[simulation]
duration = {}
{})",
                                              limit, duration, more),
                                  "limit.toml"));
}

constexpr const char* ends = "\"sqrt((150 s - t) / 1 s) > 0 - distance / 1 m\"";

TEST(Preflight, AFormulaThatEndsWithinTheFlightIsRefusedWithItsTimeAndOneThatOutlastsItIsNot) {
  const Preflight within = of(ends, 160.0);
  ASSERT_EQ(within.refusals.size(), 1u);
  EXPECT_THAT(within.refusals[0], HasSubstr("couple[0] region is no finite number"));
  EXPECT_THAT(within.refusals[0], HasSubstr("finite until t = 150 s"));
  EXPECT_THAT(of(ends, 140.0).refusals, IsEmpty());
  EXPECT_EQ(of(ends, 149.5).refusals.size(), 1u) << "the last plan looks 1 s ahead";
}

TEST(Preflight, VehiclesThatTouchBeforeTheyAreTooNearAreAWarning) {
  const std::string vehicles = "[world]\nkind = \"rotors\"\n[safety]\nbarrier = \"on\"\nd_hard = ";
  EXPECT_THAT(of("\"range < 5 m\"", 10.0, vehicles + "0.6").warnings,
              Contains(HasSubstr("a and b touch at 0.746 m, but d_hard is 0.6 m")));
  EXPECT_THAT(of("\"range < 5 m\"", 10.0, vehicles + "0.8").warnings, Not(Contains(HasSubstr("touch"))));
}

TEST(Preflight, AFormulaThatAnEventMayEndBeforeIsAWarning) {
  const Preflight p = of(ends, 160.0, "[[event]]\nat = 100.0\nremove = { couple = \"limit\" }\n");
  EXPECT_THAT(p.refusals, IsEmpty());
  EXPECT_THAT(p.warnings, Contains(HasSubstr("finite until t = 150 s: let an event end it before")));
}

TEST(Preflight, ChatterIsToldWithTheParameterThatCuresIt) {
  const std::string windows = "{ any_of = [\"40 deg < azimuth < 80 deg\", \"-80 deg < azimuth < -40 deg\"] }";
  EXPECT_THAT(of(windows, 10.0).warnings, Contains(HasSubstr("smooth = 0.01 rounds them off")));
  EXPECT_THAT(of("\"distance < 2 m\"", 10.0).warnings, Not(Contains(HasSubstr("smooth"))));
}

TEST(Preflight, ALimitInTheGlobalFrameIsJudgedAroundTheStart) {
  EXPECT_THAT(of("\"observer.p_x < -8 m\"", 10.0).warnings, Not(Contains(HasSubstr("100 % of the volume"))));
  EXPECT_THAT(of("\"observer.p_x < -30 m\"", 10.0).warnings, Contains(HasSubstr("100 % of the volume")));
}

}  // namespace
}  // namespace sightline
