#include "sightline/analysis/potential_figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "sightline/potentials.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using View = Drawing::Grid::View;

std::vector<Drawing> pictures(const Potential& p) {
  return drawings_of(p, judge(p, {.samples = 2000}), nullptr);
}

const Drawing& named(const std::vector<Drawing>& all, std::string_view what) {
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const Drawing& d) { return d.title.find(what) != std::string::npos; });
  if (found == all.end()) throw std::runtime_error("no picture of " + std::string(what));
  return *found;
}

TEST(PotentialFigures, EachHasATitleACaptionAndAxesWithUnits) {
  for (const Potential& p : {Potential(SensorCone{}), Potential(KeepOut{}), Potential(Cohesion{}),
                             Potential(Region("bearing < 1 rad").slope(Softplus{}))}) {
    std::set<std::string> titles;
    for (const Drawing& d : pictures(p)) {
      EXPECT_THAT(d.title, HasSubstr(p.name()));
      EXPECT_TRUE(titles.insert(d.title).second) << d.title;
      EXPECT_FALSE(d.caption.empty()) << d.title;
      for (const Drawing::Panel& panel : d.panels) {
        for (const std::string& label : {panel.x_label, panel.y_label}) {
          const bool of_any_limit = label == "c" || label == "dsig/dc";
          EXPECT_TRUE(of_any_limit || label.find('[') != std::string::npos) << d.title << ": " << label;
        }
        if (!panel.grid.z.empty()) {
          EXPECT_THAT(panel.grid.label, HasSubstr("[")) << d.title;
        }
        EXPECT_FALSE(panel.curves.empty() && panel.grid.z.empty()) << d.title;
      }
    }
  }
}

TEST(PotentialFigures, ShowTheStepsOfTheWorkflow) {
  const auto all = pictures(SensorCone{});
  for (const char* what : {"unit step", "in space", "slope", "sigmoid and its derivative", "the potential",
                           "global frame", "worth 0.5", "gradient", "force along", "turns the observer"}) {
    EXPECT_NO_THROW(named(all, what));
  }
  EXPECT_THROW(named(pictures(KeepOut{}), "turns the observer"), std::runtime_error)
      << "it has no yaw to show";
}

TEST(PotentialFigures, TheUnitStepIsZeroOrOneAndThePapersConeIsNarrowerThanItsLimit) {
  const Drawing d = named(pictures(SensorCone{}), "unit step");
  ASSERT_EQ(d.panels.size(), 2u);
  for (const auto& panel : d.panels) {
    for (const double z : panel.grid.z) ASSERT_TRUE(z == 0.0 || z == 1.0);
  }
  const auto inside = [&](std::size_t i) {
    return std::count(d.panels[i].grid.z.begin(), d.panels[i].grid.z.end(), 0.0);
  };
  EXPECT_NEAR(static_cast<double>(inside(1)) / static_cast<double>(inside(0)), std::sin(0.5) / std::tan(0.5),
              0.03);
}

TEST(PotentialFigures, TheUnitStepShowsTheBoundaryOfASetBesideTheSensor) {
  const Potential sensor = SensorCone{.mount = {.pitch = 0.0, .offset = 0.0}}, set = KeepOut{.d_min = 1.0};
  const Drawing d = named(drawings_of(sensor, judge(sensor, {.samples = 2000}), &set), "unit step");
  const Drawing::Curve& dots = d.panels[0].curves.back();
  EXPECT_EQ(dots.title, "certified set");
  EXPECT_GT(dots.x.size(), 50U);
  for (std::size_t i = 0; i < dots.x.size(); ++i) EXPECT_NEAR(std::hypot(dots.x[i], dots.y[i]), 1.0, 0.03);
}

/// Distances of the cloud's points from the robot.
std::pair<double, double> distances(const Drawing& d) {
  double low = INFINITY, high = 0.0;
  const auto& grid = d.panels.at(0).grid;
  EXPECT_EQ(grid.view, View::cloud);
  for (std::size_t i = 0; i < grid.z.size(); ++i) {
    const double r = std::hypot(grid.x[i] + 1, grid.y[i] + 1, grid.z[i]);
    low = std::min(low, r), high = std::max(high, r);
  }
  return {low, high};
}

TEST(PotentialFigures, KeepOutIsWorthAHalfAtOnePointThreeAndCohesionAtOnePointNineFour) {
  // Figs. 14, 16
  const auto keep_out = distances(named(pictures(KeepOut{}), "worth 0.5"));
  EXPECT_NEAR(keep_out.first, 1.30, 0.005);
  EXPECT_NEAR(keep_out.second, 1.30, 0.005);
  const auto cohesion = distances(named(pictures(Cohesion{}), "worth 0.5"));
  EXPECT_NEAR(cohesion.first, 1.94, 0.005);
  EXPECT_NEAR(cohesion.second, 1.94, 0.005);
}

TEST(PotentialFigures, ASharperSigmoidComesNearerToTheUnitStep) {
  const Drawing d = named(pictures(KeepOut{}), "the potential");
  const Drawing step = named(pictures(KeepOut{}), "slope");
  double before = INFINITY;
  for (const auto& panel : d.panels) {
    if (panel.grid.view != View::map) continue;
    double off = 0.0;
    for (std::size_t i = 0; i < panel.grid.z.size(); ++i)
      off += std::fabs(panel.grid.z[i] - step.panels[0].grid.z[i]);
    EXPECT_LT(off, before);
    before = off;
  }
}

TEST(PotentialFigures, AllHaveSomethingToShow) {
  const auto drawings = pictures(SensorCone{});
  auto shown = drawings;
  prune(shown);
  EXPECT_EQ(shown.size(), drawings.size());
}

}  // namespace
}  // namespace sightline
