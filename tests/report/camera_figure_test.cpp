#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/log.hpp"
#include "sightline/report/run_figures.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/folder.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::Not;

/// uav0, whose camera saw uav1 straight ahead, one face of its tags towards it.
Recording facing(double depth) {
  Recording r;
  r.bodies.resize(2);
  r.bodies[0].name = "uav0";
  r.bodies[0].camera = Camera{};
  r.bodies[1].name = "uav1";
  r.bodies[1].tags = Tags{};
  constexpr Quaternion turned_round = {0.0, 0.0, 0.0, 1.0};
  r.bodies[0].sighted = {{1.25, 1, {depth, 0.0, 0.0}, turned_round}};
  return r;
}

TEST(CameraFigure, WhereNoCameraSawAnythingThereIsNone) {
  EXPECT_TRUE(camera_figures(Recording{}).empty());
  Recording r = facing(2.0);
  r.bodies[0].sighted.clear();
  EXPECT_TRUE(camera_figures(r).empty());
  r = facing(2.0);
  r.bodies[0].camera.reset();
  EXPECT_TRUE(camera_figures(r).empty());
}

TEST(CameraFigure, APlateStraightAheadIsASquareOfItsPixelsInTheMiddle) {
  const auto figures = camera_figures(facing(2.0));
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_EQ(figures[0].title, "What the camera of uav0 saw");
  const double half = 0.5 * Camera{}.pixels(0.2, 2.0 - Tags{}.distance);
  EXPECT_THAT(figures[0].svg, HasSubstr(fmt::format("{:.1f},{:.1f}", 160 - half, 120 + half)));
  EXPECT_THAT(figures[0].svg, HasSubstr(fmt::format("{:.1f},{:.1f}", 160 + half, 120 - half)));
  EXPECT_THAT(figures[0].svg, HasSubstr("1.25 s: uav1, 2.00 m"));
  // White, black and code of one plate: the three others are seen from behind or from the side.
  std::size_t plates = 0;
  for (std::size_t at = 0; (at = figures[0].svg.find("<polygon", at)) != std::string::npos; ++at) ++plates;
  EXPECT_EQ(plates, 3U);
}

TEST(CameraFigure, AnAttitudeThatNobodyKnowsAndAPlateThatIsTooNearAreNoPlates) {
  Recording r = facing(2.0);
  r.bodies[0].sighted[0].q = no_attitude;
  EXPECT_THAT(camera_figures(r).at(0).svg, HasSubstr("<circle cx=\"160.0\" cy=\"120.0\""));
  EXPECT_THAT(camera_figures(facing(0.1)).at(0).svg, Not(HasSubstr("<polygon")));
}

TEST(CameraFigure, WhatAFurtherCameraSawIsLeftOut) {
  Recording r = facing(2.0);
  r.bodies[0].sighted.push_back(r.bodies[0].sighted[0]);
  r.bodies[0].sighted[1].p = {0.0, -2.0, 0.0};
  const Figure figure = camera_figures(r).at(0);
  EXPECT_THAT(figure.caption, HasSubstr("1 of its 1 detections"));
  EXPECT_THAT(figure.svg, Not(HasSubstr("translate(252.0 0.0)")));
  // The middle of a body is out of the picture, some of its tags are in it.
  r.bodies[0].sighted[1] = {1.25, 1, {0.5, -0.4, 0.0}, {std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}};
  EXPECT_THAT(camera_figures(r).at(0).caption, HasSubstr("2 of its 2 detections"));
  r.bodies[0].sighted = {{1.25, 1, {-2.0, 0.0, 0.0}, no_attitude}};
  EXPECT_TRUE(camera_figures(r).empty());
}

TEST(CameraFigure, AFlightShowsSixOfItsPicturesAsItsLogHasThem) {
  const Scenario scenario =
      read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/localize.toml", built_in_registry(),
                    {"simulation.duration=2", "simulation.settle=1"});
  const test::Folder folder("camera_figure_test");
  const Controls controls(scenario);
  SimulatedClock clock;
  const LoggedFlight flight = fly_logged(scenario, folder.path(), clock, controls.controllers());
  ASSERT_TRUE(flight.logged);
  const Recording recording = read_recording(folder.path());
  const Recording::Body& observer = recording.bodies.at(0);
  ASSERT_TRUE(observer.camera);
  EXPECT_EQ(observer.camera->width, 320);
  ASSERT_TRUE(recording.bodies.at(1).tags);
  EXPECT_EQ(*recording.bodies[1].tags, scenario.vision.tags.at(0).tags);
  EXPECT_GT(observer.sighted.size(), 40U);
  const std::string svg = camera_figures(recording).at(0).svg;
  std::size_t pictures = 0;
  for (std::size_t at = 0; (at = svg.find("<g transform", at)) != std::string::npos; ++at) ++pictures;
  EXPECT_EQ(pictures, 6U);
  EXPECT_THAT(svg, HasSubstr("<polygon"));
}

}  // namespace
}  // namespace sightline
