#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/report/run_figures.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

// Bodies at rest in a row along y.
Recording row(std::size_t bodies, double apart = 1.0) {
  Recording r;
  r.period = 0.1;
  for (int k = 0; k < 50; ++k) r.time.push_back(0.1 * k);
  r.bodies.resize(bodies);
  for (std::size_t i = 0; i < bodies; ++i) {
    r.bodies[i].name = "uav" + std::to_string(i);
    r.bodies[i].is_agent = true;
    r.bodies[i].p.assign(50, {0.0, apart * static_cast<double>(i), 1.0});
    r.bodies[i].heading.assign(50, 0.0);
  }
  return r;
}

Drawing drawn(const Recording& r) { return paths_drawing(r, Curves(r)); }

TEST(PathsFigure, EveryPathHasItsNameInTheLegendOrBesideIt) {
  for (const std::size_t bodies : {1u, 6u, 7u, 8u, 32u}) {
    const Drawing drawing = drawn(row(bodies));
    std::size_t named = drawing.panels[0].labels.size();
    for (const auto& curve : drawing.panels[0].curves)
      named += curve.mark == Drawing::Mark::line && !curve.title.empty();
    EXPECT_EQ(named, bodies);
  }
}

TEST(PathsFigure, TheSideIsSeenAcrossTheLongerExtentWithTheFloor) {
  Recording r = row(3);
  EXPECT_EQ(drawn(r).panels[1].x_label, "y [m]");
  r.bodies[1].p[7].x = 9.0;
  EXPECT_EQ(drawn(r).panels[1].x_label, "x [m]");
  const std::size_t curves = drawn(r).panels[1].curves.size();
  r.floor = 0.3;
  ASSERT_EQ(drawn(r).panels[1].curves.size(), curves + 1);
  EXPECT_EQ(drawn(r).panels[1].curves.back().y, (std::vector<double>{0.3, 0.3}));
}

TEST(PathsFigure, EachZoneIsAClosedLineFromAbove) {
  Recording r = row(3);
  const std::size_t curves = drawn(r).panels[0].curves.size();
  r.zones = {{{1, 1}, {2, 1}, {2, 3}}, {{4, 4}, {5, 4}, {5, 5}, {4, 5}}};
  const Drawing drawing = drawn(r);
  ASSERT_EQ(drawing.panels[0].curves.size(), curves + 2);
  const auto is_zone = [](const auto& curve) { return curve.title == "zones"; };
  const auto& all = drawing.panels[0].curves;
  const auto zone = std::find_if(all.begin(), all.end(), is_zone);
  ASSERT_NE(zone, all.end());
  EXPECT_EQ(zone->x, (std::vector<double>{1, 2, 2, 1}));
  EXPECT_EQ(zone->y, (std::vector<double>{1, 1, 3, 1}));
  EXPECT_EQ(std::count_if(all.begin(), all.end(), is_zone), 1) << "one entry of the legend";
}

TEST(PathsFigure, TheFootprintBeginsAtTheSensorAndLiesWhereItLooks) {
  Recording r = row(2);
  r.bodies[0].heading.assign(50, 0.5);
  const SensorMount mount = {.pitch = 0.2, .offset = {0.1, 0.3, 0.2}, .yaw = 1.2, .roll = 2.0};
  r.pairs.push_back({.observer = 0, .target = 1, .mount = mount, .alpha = 0.4, .d_min = 1, .d_max = 3});
  const Drawing drawing = drawn(r);
  const auto& all = drawing.panels[0].curves;
  const auto edge =
      std::find_if(all.begin(), all.end(), [](const auto& c) { return c.mark == Drawing::Mark::dashed; });
  ASSERT_NE(edge, all.end());
  const double c = std::cos(0.5), s = std::sin(0.5), x = edge->x[0], y = edge->y[0];
  EXPECT_NEAR(x - r.bodies[0].p.back().x, 0.1 * c - 0.3 * s, 1e-12);
  EXPECT_NEAR(y - r.bodies[0].p.back().y, 0.1 * s + 0.3 * c, 1e-12);
  const std::size_t middle = edge->x.size() / 2;
  EXPECT_NEAR(std::atan2(edge->y[middle] - y, edge->x[middle] - x), 0.5 + 1.2, 1e-9);
}

TEST(PathsFigure, TheFootprintIsTheShadowOfTheCone) {
  Random random(1);
  for (int n = 0; n < 200; ++n) {
    Recording r = row(2);
    const double alpha = uniform(random, 0.1, 0.7), pitch = uniform(random, -0.7, 0.7);
    r.bodies[0].heading.assign(50, 0.0);
    r.pairs.push_back(
        {.observer = 0, .target = 1, .mount = {pitch, 0.1}, .alpha = alpha, .d_min = 1, .d_max = 3});
    const Drawing drawing = drawn(r);
    EXPECT_THAT(drawing.caption, HasSubstr("what the sensor covers"));
    for (const auto& curve : drawing.panels[0].curves) {
      if (curve.mark != Drawing::Mark::dashed) continue;
      ASSERT_GT(curve.x.size(), 3U);
      const double half = std::abs(std::atan2(curve.y[1] - curve.y[0], curve.x[1] - curve.x[0]));
      EXPECT_DOUBLE_EQ(curve.x[0], 0.1);
      // No point of the cone is seen from above outside the sector, and some come to its edge.
      double widest = 0.0;
      for (int i = 0; i < 720; ++i) {
        const double phi = i * std::numbers::pi / 360;
        const double x = std::cos(alpha), y = std::sin(alpha) * std::cos(phi),
                     z = std::sin(alpha) * std::sin(phi);
        widest = std::max(widest, std::abs(std::atan2(y, x * std::cos(pitch) + z * std::sin(pitch))));
      }
      EXPECT_NEAR(half, widest, 1e-4);
    }
  }
}

TEST(PathsFigure, TheCaptionSpeaksOfWhatIsThereAlone) {
  EXPECT_THAT(drawn(row(2)).caption, Not(HasSubstr("grey")));
  EXPECT_THAT(drawn(row(2)).caption, Not(HasSubstr("dashed")));
  Recording r = row(2);
  r.pairs.push_back({.observer = 0, .target = 1, .alpha = std::nan("")});
  EXPECT_THAT(drawn(r).caption, HasSubstr("grey"));
  EXPECT_THAT(drawn(r).caption, Not(HasSubstr("dashed"))) << "a region has no cone";
}

}  // namespace
}  // namespace sightline
