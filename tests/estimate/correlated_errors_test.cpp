#include "sightline/estimate/correlated_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/filter_derivatives.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/synthetic_flight.hpp"

namespace sightline {
namespace {

using test::Consistency;
using test::fly_filters;

constexpr SensorMount on_the_body{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::body};
constexpr SensorMount held_level{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::level};
constexpr FilterOptions correlated{.correlation_time = 0.5};

/// Of filters with states for the errors of one sensor and of four.
template <class Filter>
void expect_derivatives(double propagation = 1e-8) {
  for (const SensorMount& mount : {on_the_body, held_level}) {
    test::expect_propagation(Filter(correlated, mount), propagation);
    test::expect_sensitivity(Filter(correlated, mount), 1e-6);
  }
}

TEST(CorrelatedErrors, TheirCovarianceGoesOnAsTheyDoAndAnInnovationChangesWithThemAsHSays) {
  expect_derivatives<HeadingFilterOf<0, 1>>();
  expect_derivatives<HeadingFilterOf<1, correlated_sources_max>>();
  expect_derivatives<AttitudeFilterOf<1>>(2e-5);
}

// A flight is about one draw of each of 4 errors for each correlation time. So the mean of 30
// flights of 11 s is within a fifth of 4.
TEST(CorrelatedErrors, AFilterThatKnowsTheirTimeIsConsistentAndOneThatTakesThemAsWhiteIsOverconfident) {
  for (const FilterKind kind : {FilterKind::heading, FilterKind::attitude}) {
    for (const double time : {0.5, 2.0, 5.0}) {
      const test::SyntheticOptions flight{.correlation_time = time};
      const Consistency right = fly_filters({.filter = kind, .correlation_time = time}, flight, 30, 14.0);
      EXPECT_GT(right.anees(), 3.2) << time;
      EXPECT_LT(right.anees(), 5.0) << time;
      EXPECT_EQ(right.unknown, 0);
      EXPECT_EQ(right.restarts, 0);
      const Consistency white = fly_filters({.filter = kind}, flight, 30, 14.0);
      EXPECT_GT(white.anees(), 7.0) << time;
      EXPECT_LT(right.rmse(), 1.02 * white.rmse()) << time << ": it is as accurate";
    }
  }
}

/// A robot at rest, 2 m from a body that it sees ten times a second with the same error.
Mat<4, 4> covariance_after(const FilterOptions& options, const FilterKind kind, int sightings) {
  FilterOptions still = options;
  still.filter = kind;
  still.start_sightings = 1;
  still.velocity_noise = 1e-6, still.velocity_bias = 1e-4, still.tilt_bias = 1e-5;
  still.yaw_rate_noise = 1e-6, still.yaw_rate_bias = 1e-5, still.gyro_noise = 1e-6, still.gyro_bias = 1e-5;
  still.accelerometer_noise = 1e-3, still.accelerometer_bias = 1e-5;
  const auto filter = make_pose_filter(still, held_level);
  Measurement z{.z = {1.5, 0.1, 0.2}, .R = identity<3>(4e-4), .has_yaw = true, .yaw_variance = 1e-3};
  z.R_yaw = {1e-4, -2e-4, 1e-4};
  z.P_other = identity<4>(1e-10);
  int taken = 0;
  for (int k = 0; taken < sightings; ++k) {
    filter->advance({.t = 0.01 * k, .force = {0, 0, gravity}});
    if (k % 10 != 5) continue;
    z.stamp = 0.01 * k;
    EXPECT_LE(static_cast<int>(filter->take(z).verdict), static_cast<int>(FitVerdict::started)) << k;
    ++taken;
  }
  return filter->estimate().P;
}

TEST(CorrelatedErrors, WhatLastsIsNotAveragedAwayFromTheFirstSightingOn) {
  for (const FilterKind kind : {FilterKind::heading, FilterKind::attitude}) {
    const FilterOptions lasting{.correlation_time = 1e5};
    const Mat<4, 4> first = covariance_after({}, kind, 1), white = covariance_after({}, kind, 30),
                    kept = covariance_after(lasting, kind, 30);
    for (int i = 0; i < 4; ++i) {
      EXPECT_LT(white(i, i), 0.1 * first(i, i)) << i;
      EXPECT_GT(kept(i, i), 0.95 * 4e-4) << i << ": the sighting's own";
      EXPECT_LT(kept(i, i), 1.4 * first(i, i)) << i;
    }
  }
}

TEST(CorrelatedErrors, EachSourceHasItsOwnAndBeyondThemAMeasurementCountsAsWhite) {
  const FilterOptions options{.compass_noise = 0.1, .compass_time = 3.0, .correlation_time = 2.0};
  CorrelatedErrors<2> errors;
  Measurement z{.source = 7, .R = identity<3>(0.04), .yaw_variance = 0.25};
  EXPECT_EQ(errors.corrected(z, 10).row, -1) << "it has none yet";
  errors.receive({.of = Measures::position, .source = 3}, options);
  errors.receive(z, options);
  errors.receive(z, options);
  errors.receive({.of = Measures::heading, .source = compass_source}, options);
  errors.receive({.source = 9}, options);
  EXPECT_EQ(errors.corrected(z, 10).row, 10);
  z.source = 9;
  EXPECT_EQ(errors.corrected(z, 10).row, -1);
  EXPECT_EQ(errors.corrected(z, 10).z.R(0, 0), 0.04);
  Measurement heading{.of = Measures::heading, .source = compass_source, .yaw = 1.0, .yaw_variance = 0.01};
  errors.x[1](3, 0) = 2.0;
  const auto corrected = errors.corrected(heading, 10);
  EXPECT_EQ(corrected.row, 14);
  EXPECT_NEAR(corrected.z.yaw, 0.8, 1e-12) << "two standard deviations of 0.1 rad";
  EXPECT_EQ(corrected.z.yaw_variance, 0.0);

  Mat<18, 18> P;
  errors.begin(P, 10);
  P(0, 14) = P(14, 0) = 0.5;
  errors.advance(P, 10, options, 0.6);
  EXPECT_NEAR(errors.x[1](3, 0), 2 * std::exp(-0.2), 1e-12) << "the compass has its own time";
  EXPECT_NEAR(P(0, 14), 0.5 * std::exp(-0.2), 1e-12);
  EXPECT_NEAR(P(14, 14), 1.0, 1e-12);
}

TEST(CorrelatedErrors, MoreSourcesThanAFilterHasStatesForAreRefused) {
  const FilterOptions sightings{.correlation_time = 1.0};
  EXPECT_NO_THROW(make_pose_filter(sightings, held_level, correlated_sources_max));
  EXPECT_NO_THROW(make_pose_filter({}, held_level, 100));
  EXPECT_EQ(refusal_of([&] { make_pose_filter(sightings, held_level, correlated_sources_max + 1); }),
            "errors of 5 sensors are correlated in time, expected at most 4");
}

}  // namespace
}  // namespace sightline
