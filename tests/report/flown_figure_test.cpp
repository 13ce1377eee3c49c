#include "sightline/report/flown_figure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

/// Ten periods of an observer at the origin that leans by 0.1 forward, planned 0.05, and a target
/// that flies along y at 1 m/s.
Recording observed(bool target_is_robot) {
  Recording r;
  r.period = 0.1;
  r.bodies.resize(2);
  r.bodies[0].name = "uav0";
  r.bodies[1].name = "seen";
  r.bodies[0].is_agent = r.bodies[0].leans = true;
  r.bodies[1].is_agent = target_is_robot;
  for (int k = 0; k < 10; ++k) {
    r.time.push_back(0.1 * k);
    for (Recording::Body& body : r.bodies) {
      const bool is_seen = &body == &r.bodies[1];
      body.p.push_back(is_seen ? Vec3<double>{2, 0.1 * k, 0} : Vec3<double>{});
      body.v.push_back(is_seen ? Vec3<double>{0, 1, 0} : Vec3<double>{});
      body.heading.push_back(0.0);
      body.lean.push_back(is_seen ? Vec2<double>{} : Vec2<double>{0.1, 0});
      if (is_seen && !target_is_robot) continue;
      body.planned_time.push_back(0.1 * k + 0.2);
      Sight<double> planned;
      planned.p = is_seen ? Vec3<double>{2, 0.1 * k + 0.3, 0} : Vec3<double>{};
      planned.d = {1, 0};
      planned.lean = {is_seen ? 0.0 : 0.05, 0};
      body.planned.push_back(planned);
    }
  }
  r.pairs.push_back({0, 1, {0.0, 0.0, MountFrame::level}, 0.5, 1.0, 2.0});
  return r;
}

TEST(FlownFigure, AnAngleIsPlannedTowardsThePlanOfARobotAndTheHeldVelocityOfOthers) {
  for (const bool robot : {true, false}) {
    const Recording r = observed(robot);
    const PlannedAngles planned = planned_angles(r, r.pairs[0]);
    ASSERT_GE(planned.time.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_NEAR(planned.time[i], 0.1 * static_cast<double>(i) + 0.2, 1e-12);
      const double aside = 0.1 * static_cast<double>(i) + (robot ? 0.3 : 0.2);
      EXPECT_NEAR(planned.angle[i], std::atan2(aside, 2.0), 1e-12) << robot;
    }
  }
}

TEST(FlownFigure, WhatDoesNotLeanHasNone) {
  Recording r = observed(true);
  r.bodies[0].leans = false;
  EXPECT_TRUE(planned_angles(r, r.pairs[0]).time.empty());
  EXPECT_FALSE(flown_drawing(r, Curves(r), {0, 1}));
}

TEST(FlownFigure, TiltsAreAnglesAndTheDistanceIsFromWhatIsAskedFor) {
  Recording r = observed(true);
  const auto without = flown_drawing(r, Curves(r), {0, 1});
  ASSERT_TRUE(without);
  ASSERT_EQ(without->panels.size(), 1u) << "nothing is asked for";
  ASSERT_EQ(without->panels[0].curves.size(), 2u);
  EXPECT_NEAR(without->panels[0].curves[0].y.front(), std::atan(0.1), 1e-12);
  EXPECT_NEAR(without->panels[0].curves[1].y.front(), std::atan(0.05), 1e-12);
  EXPECT_EQ(without->panels[0].curves[1].x.front(), 0.2);
  EXPECT_EQ(without->panels[0].x_label, "t [s]");

  r.bodies[0].reference_time = {0.0, 0.5};
  r.bodies[0].reference_p = {{0.3, 0.4, 0.0}, {0.0, 0.0, 1.0}};
  const auto with = flown_drawing(r, Curves(r), {0, 1});
  ASSERT_EQ(with->panels.size(), 2u);
  EXPECT_EQ(with->panels[1].curves[0].y, (std::vector<double>{0.5, 1.0}));
}

TEST(FlownFigure, TheTableHasARowForEachPairAndRobotThatLeans) {
  const std::string summary = R"({ "pairs": [
      { "observer": "uav0", "target": "a<b", "view_angle_mean": 0.25,
        "planned_view_angle": { "ahead": 0.2, "mean": 0.125, "rms": 0.5 } },
      { "observer": "uav1", "target": "uav0" }],
    "agents": [
      { "name": "uav0", "tilt_max": 0.75, "planned_tilt": { "ahead": 0.2, "max": 0.625, "rms": 0.375 },
        "position_offset": 2.5, "tracking_error": 1.5 },
      { "name": "uav1" }] })";
  const std::string table = flown_table(summary);
  for (const char* words :
       {"uav0 sees a&lt;b: view angle", "<td>0.125 rad</td><td>0.250 rad</td><td>0.500 rad</td>",
        "<td>0.625 rad</td><td>0.750 rad</td><td>0.375 rad</td>", "2.50 m", "1.50 m"})
    EXPECT_THAT(table, HasSubstr(words));
  EXPECT_THAT(table, testing::Not(HasSubstr("uav1")));
  EXPECT_EQ(flown_table(R"({ "pairs": [], "agents": [{ "name": "uav1" }] })"), "");
  EXPECT_THAT(refusal_of<std::runtime_error>([] { flown_table("{}"); }), HasSubstr("no summary of a run"));
}

}  // namespace
}  // namespace sightline
