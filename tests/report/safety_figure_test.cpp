#include <gtest/gtest.h>

#include <cmath>

#include "sightline/report/run_figures.hpp"

namespace sightline {
namespace {

Recording two_robots() {
  Recording r;
  r.period = 0.1;
  r.bodies.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    r.bodies[i].name = i == 2 ? "wall" : i == 1 ? "b" : "a";
    r.bodies[i].is_agent = i < 2;
  }
  for (int k = 0; k < 10; ++k) r.time.push_back(0.1 * k);
  return r;
}

TEST(SafetyFigure, AFlightInWhichNothingHappenedHasNone) {
  Recording r = two_robots();
  r.events = {{0.3, "solver_status", 0, 1.0}};
  r.bodies[0].barrier.assign(10, 0.0);
  EXPECT_FALSE(safety_drawing(r));
  EXPECT_FALSE(safety_drawing(Recording{}));
}

TEST(SafetyFigure, RungsAreStepsFromTheFirstToTheEnd) {
  Recording r = two_robots();
  r.events = {{0.2, "predicted", 0, 1.0}, {0.4, "hold", 0, 1.0}, {0.5, "measurement_jump", 0, 1.0}};
  const auto drawing = safety_drawing(r);
  ASSERT_TRUE(drawing);
  ASSERT_EQ(drawing->panels.size(), 1U);
  ASSERT_EQ(drawing->panels[0].curves.size(), 1U);
  const Drawing::Curve& steps = drawing->panels[0].curves[0];
  EXPECT_EQ(steps.title, "b");
  EXPECT_EQ(steps.x, (std::vector<double>{0.0, 0.2, 0.2, 0.4, 0.4, r.time.back() + 0.1}));
  EXPECT_EQ(steps.y, (std::vector<double>{0, 0, 1, 1, 3, 3}));
  EXPECT_EQ(drawing->panels[0].x_label, "t [s]");
}

TEST(SafetyFigure, ValuesHaveNamesAndTheCaptionSpeaksOfWhatIsThereAlone) {
  Recording r = two_robots();
  r.events = {{0.2, "hold", 0, 1.0}};
  EXPECT_EQ(safety_drawing(r)->panels[0].y_names.at(3), "hold");
  EXPECT_EQ(safety_drawing(r)->caption.find("barrier"), std::string::npos);
  r.events.clear();
  r.bodies[0].barrier.assign(10, 1.0);
  const auto drawing = safety_drawing(r);
  EXPECT_EQ(drawing->panels[0].y_names, (std::vector<std::string>{"", "a", "b"}));
  EXPECT_EQ(drawing->panels[0].y_range, (std::array{0.4, 2.6}));
  EXPECT_NE(drawing->caption.find("barrier"), std::string::npos);
}

TEST(SafetyFigure, TheBarrierIsALineWhereItActs) {
  Recording r = two_robots();
  r.bodies[1].barrier = {0, 1, 1, 0, 0, 0, 1, 1, 1, 1};
  const auto drawing = safety_drawing(r);
  ASSERT_TRUE(drawing);
  const Drawing::Curve& acts = drawing->panels.at(0).curves.at(0);
  ASSERT_EQ(acts.x.size(), 5U);
  EXPECT_EQ(acts.x[0], r.time[1]);
  EXPECT_EQ(acts.x[1], r.time[3]);
  EXPECT_TRUE(std::isnan(acts.y[2])) << "a gap";
  EXPECT_EQ(acts.x[3], r.time[6]);
  EXPECT_EQ(acts.x[4], r.time[9] + 0.1);
  EXPECT_EQ(acts.y[4], 2.0) << "at the height of its robot";
}

}  // namespace
}  // namespace sightline
