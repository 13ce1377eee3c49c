#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/band_flight.hpp"

namespace sightline {
namespace {

/// Whether one is at most so many times the other.
void expect_within(double received, double flown, double factor, std::string_view what, double distance) {
  EXPECT_LE(received, factor * flown) << what << " at " << distance;
  EXPECT_LE(flown, factor * received) << what << " at " << distance;
}

/// fly_beside() against a closed loop with its solver, latencies and gusts.
TEST(ViewFlight, WhatIsToldOfADistanceIsWhatAHundredFlightsShow) {
  constexpr int flights = 100;
  fmt::print("camera  distance  found          error             view lost\n");
  for (const MountFrame frame : {MountFrame::level, MountFrame::body}) {
    for (const double distance : {1.0, 1.5, 2.0, 2.5, 2.75, 3.0}) {
      const ViewFlight view{.mount = {.frame = frame}, .target_speed = 0.5};
      const ViewFigures received = mean_figures(view, distance, flights),
                        flown = mean_figures(view, distance, flights, test::fly_in_loop);
      fmt::print("{}   {:.2f} m  {:3.0f} %, {:3.0f} %  {:4.1f} mm, {:4.1f} mm  {:4.1f}, {:4.1f} a minute\n",
                 frame == MountFrame::level ? "level" : "body ", distance, 100 * received.found,
                 100 * flown.found, 1e3 * received.sigma, 1e3 * flown.error, received.losses, flown.losses);
      expect_within(received.sigma, flown.error, 1.3, "error", distance);
      if (received.losses > 1.0) {
        expect_within(received.losses, flown.losses, 1.3, "losses", distance);
      }
      if (received.losses < 0.1) {
        EXPECT_LE(flown.losses, 1.0) << distance;
      }
    }
  }
}

}  // namespace
}  // namespace sightline
