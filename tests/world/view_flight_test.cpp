#include "sightline/world/view_flight.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/drawn_layout.hpp"

namespace sightline {
namespace {

using test::Chooses;

TEST(ViewFlight, WhatTheFilterSaysIsWhatItsErrorsAre) {
  const SensorMount aside = {.pitch = 0.5, .offset = {0.1, 0.15, -0.05}, .yaw = 1.57, .roll = 0.5};
  for (SensorMount mount : {SensorMount{}, SensorMount{}, aside, aside}) {
    static int number = 0;
    mount.frame = number++ % 2 == 0 ? MountFrame::level : MountFrame::body;
    double error = 0.0, sigma = 0.0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const ViewFigures at = fly_beside({.mount = mount, .target_speed = 0.3, .seed = seed}, 1.5);
      EXPECT_GT(at.found, 0.9);
      EXPECT_GT(at.known, 0.99);
      EXPECT_EQ(at.losses, 0.0);
      error += square(at.error), sigma += square(at.sigma);
    }
    EXPECT_LT(std::sqrt(error / sigma), 1.3) << mount.yaw << static_cast<int>(mount.frame);
    EXPECT_GT(std::sqrt(error / sigma), 1 / 1.3);
  }
}

TEST(ViewFlight, FartherIsWorseAndBeyondTheReachThereIsNothing) {
  const ViewFlight flight{.target_speed = 0.2};
  double before = 0.0;
  for (const double distance : {1.0, 1.5, 2.0, 2.5}) {
    const ViewFigures at = fly_beside(flight, distance);
    EXPECT_GT(at.sigma, before) << distance;
    before = at.sigma;
  }
  const ViewFigures beyond = fly_beside(flight, 6.0);
  EXPECT_EQ(beyond.found, 0.0);
  EXPECT_EQ(beyond.known, 0.0);
  EXPECT_EQ(beyond.sigma, std::numeric_limits<double>::infinity());
  EXPECT_EQ(beyond.lost, 1.0);
  EXPECT_LT(fly_beside(flight, 0.2).found, 0.5) << "a tag fills more than the picture";
}

TEST(ViewFlight, TheVarianceOverTheDistanceEndsWhereTagsAreTooSmall) {
  const ViewFlight flight{.duration = 10.0};
  const ViewVariance small = view_variance(flight);
  ViewFlight finer = flight;
  finer.camera.width = 640, finer.camera.height = 480;
  const ViewVariance large = view_variance(finer);
  EXPECT_TRUE(std::isfinite(small.at(2.5)));
  EXPECT_FALSE(std::isfinite(small.at(4.5)));
  EXPECT_TRUE(std::isfinite(large.at(5.0)));
  EXPECT_LT(large.at(2.0), small.at(2.0));
  EXPECT_EQ(small.at(0.0), small.at(0.25)) << "too near to be seen: as at the nearest";
}

TEST(ViewFlight, OfEightRobotsTheBestKnowTheirPlacesBetterThanTheNearest) {
  constexpr int layouts = 4;
  for (const double area : {5.0, 8.0, 12.0}) {
    const test::LayoutFigures best = fly_layouts({.area = area}, Chooses::best, layouts),
                              nearest = fly_layouts({.area = area}, Chooses::nearest, layouts);
    EXPECT_LT(best.sigma(), 0.8 * nearest.sigma()) << area;
    EXPECT_LT(best.share(best.blind), nearest.share(nearest.blind) / 3) << area;
    EXPECT_GE(best.least_between, ViewChoice{}.dwell - 1e-9) << area;
    if (area == 5.0) {
      EXPECT_LT(best.changes_a_minute(), 0.5 * nearest.changes_a_minute());
    }
  }
}

}  // namespace
}  // namespace sightline
