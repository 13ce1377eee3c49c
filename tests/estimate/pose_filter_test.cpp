#include <gtest/gtest.h>

#include "sightline/estimator.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/synthetic_flight.hpp"

namespace sightline {
namespace {

using test::Consistency;
using test::fly_filters;
using test::SyntheticFlight;
using test::SyntheticOptions;

constexpr FilterOptions by_heading{.filter = FilterKind::heading};
constexpr FilterOptions by_attitude{.filter = FilterKind::attitude};

// The errors of one flight are alike for seconds, so the bands are of the mean of N flights, not of
// samples. Were a flight one draw, the mean NEES of 4 errors would be within 4 +- 1.96 sqrt(8 / N)
// in 95 of 100.
TEST(PoseFilter, TheErrorOfTheHeadingFilterIsWhatItsCovarianceSays) {
  const Consistency flown = fly_filters(by_heading, {}, 200, 14.0);
  EXPECT_GT(flown.anees(), 3.4);
  EXPECT_LT(flown.anees(), 4.6);
  EXPECT_LT(flown.rmse(), 0.025);
  EXPECT_EQ(flown.unknown, 0);
  EXPECT_EQ(flown.restarts, 0);
}

TEST(PoseFilter, TheErrorOfTheAttitudeFilterIsWhatItsCovarianceSays) {
  const Consistency flown = fly_filters(by_attitude, {}, 60, 14.0);
  EXPECT_GT(flown.anees(), 3.0);
  EXPECT_LT(flown.anees(), 4.6);
  EXPECT_LT(flown.rmse(), 0.012);
  EXPECT_EQ(flown.unknown, 0);
  EXPECT_EQ(flown.restarts, 0);
}

TEST(PoseFilter, SlowCamerasAndMessagesCostAccuracyAndNotTruth) {
  const Consistency camera = fly_filters(by_heading, {.camera_rate = 10}, 60, 14.0);
  EXPECT_LT(camera.rmse(), 0.030);
  EXPECT_LT(camera.anees(), 5.0);
  const Consistency radio = fly_filters(by_heading, {.broadcast_rate = 10}, 60, 14.0);
  EXPECT_LT(radio.rmse(), 0.030);
  EXPECT_LT(radio.anees(), 6.0);
}

TEST(PoseFilter, OutliersAndFlipsDoNoHarm) {
  for (const FilterOptions& options : {by_heading, by_attitude}) {
    const int flights = options.filter == FilterKind::heading ? 60 : 30;
    const Consistency clean = fly_filters(options, {}, flights, 12.0);
    for (const double share : {0.1, 0.2}) {
      const Consistency spoiled = fly_filters(options, {.outliers = share, .flips = share}, flights, 12.0);
      EXPECT_LT(spoiled.rmse(), 1.1 * clean.rmse()) << share;
      EXPECT_LT(spoiled.anees(), 4.6) << share;
      EXPECT_LE(spoiled.restarts, 2) << share << ": one may begin by outliers that agree";
    }
  }
}

TEST(PoseFilter, ACameraHeldLevelOrATargetAtRestIsSeenAsWell) {
  for (const FilterOptions& options : {by_heading, by_attitude}) {
    SyntheticOptions level;
    level.mount.frame = MountFrame::level;
    EXPECT_LT(fly_filters(options, level, 20, 10.0).anees(), 5.0);
    EXPECT_LT(fly_filters(options, {.hovers = true}, 20, 10.0).anees(), 5.0);
  }
}

TEST(PoseFilter, ACameraThatSitsAskewIsFoundOutByItsTurn) {
  FilterOptions turned = by_attitude;
  turned.camera_turn = 0.02;
  SyntheticOptions askew;
  askew.misalignment = 0.02;
  const Consistency received = fly_filters(turned, askew, 12, 30.0),
                    unreported = fly_filters(by_attitude, askew, 12, 30.0);
  EXPECT_LT(received.anees(), 5.0);
  EXPECT_GT(unreported.anees(), 10.0);
  EXPECT_LT(received.rmse(), unreported.rmse());
}

TEST(PoseFilter, WhileItIsBlindItsCovarianceGrowsAsTheError) {
  for (const FilterOptions& options : {by_heading, by_attitude}) {
    constexpr int flights = 150;
    double squares = 0.0, said = 0.0;
    std::vector<Measurement> arrived;
    for (int i = 0; i < flights; ++i) {
      SyntheticFlight flight({.seed = static_cast<std::uint64_t>(i), .blind_from = 6.0});
      const auto filter = make_pose_filter(options, flight.o.mount);
      while (flight.now() < 8.0) {
        filter->advance(flight.advance(arrived));
        for (const Measurement& z : arrived) filter->take(z);
      }
      const PoseEstimate estimate = filter->estimate();
      const Vec3<double> e = estimate.p - flight.own().p;
      squares += dot(e, e), said += square(estimate.position_sigma());
      EXPECT_NEAR(estimate.last_accepted, 6.0, 0.2);
    }
    EXPECT_NEAR(std::sqrt(said / squares), 1.0, 0.2);
  }
}

TEST(PoseFilter, TheCovarianceIsSymmetricAndPositiveAllTheTime) {
  for (const FilterOptions& options : {by_heading, by_attitude}) {
    SyntheticFlight flight({.seed = 3, .outliers = 0.2, .blind_from = 3.0, .blind_until = 5.0});
    const auto filter = make_pose_filter(options, flight.o.mount);
    std::vector<Measurement> arrived;
    while (flight.now() < 8.0) {
      filter->advance(flight.advance(arrived));
      for (const Measurement& z : arrived) filter->take(z);
      const PoseEstimate estimate = filter->estimate();
      if (!estimate.known) continue;
      ASSERT_LE(std::abs(estimate.P(0, 3) - estimate.P(3, 0)), 1e-15);
      ASSERT_TRUE(Cholesky<4>(estimate.P).positive) << flight.now();
    }
  }
}

/// Tells a settled filter another pose, as sure as it was of its own.
/// @return until it is right again [s]; 10 if never
double recovery(const FilterOptions& options, std::uint64_t seed, const Vec3<double>& off, double turned,
                double outliers = 0.0) {
  SyntheticFlight flight({.seed = seed, .outliers = outliers, .flips = outliers});
  const auto filter = make_pose_filter(options, flight.o.mount);
  std::vector<Measurement> arrived;
  const auto go_on = [&] {
    filter->advance(flight.advance(arrived));
    for (const Measurement& z : arrived) filter->take(z);
    return filter->estimate();
  };
  while (flight.now() < 2.0) go_on();
  const PoseEstimate before = filter->estimate();
  filter->start(before.p + off, before.psi + turned, before.P);
  while (flight.now() < 12.0) {
    const PoseEstimate estimate = go_on();
    const Column<4> e = test::pose_error(estimate, flight.own());
    if (estimate.known && norm(vec3(e)) < 0.1 && std::abs(e(3, 0)) < 0.05) return flight.now() - 2.0;
  }
  return 10.0;
}

TEST(PoseFilter, AWrongPoseIsFoundOut) {
  for (const FilterOptions& options : {by_heading, by_attitude}) {
    for (std::uint64_t seed = 0; seed < 25; ++seed) {
      EXPECT_LT(recovery(options, seed, {0.8, 0.8, 0.0}, 2.0), 1.0) << seed;
      EXPECT_LT(recovery(options, seed, {0.8, 0.8, 0.0}, 0.0), 1.0) << seed;
      EXPECT_LT(recovery(options, seed, {0.8, 0.8, 0.0}, 2.0, 0.2), 5.0) << seed;
    }
  }
}

TEST(PoseFilter, PositionsThatFitDoNotLockAWrongHeadingIn) {
  for (const FilterOptions& options : {by_heading, by_attitude})
    for (std::uint64_t seed = 0; seed < 25; ++seed)
      for (const double turned : {0.15, 0.4, 1.0, 2.0, -3.0})
        EXPECT_LT(recovery(options, seed, {}, turned), 1.5) << seed << ", turned by " << turned;
}

// Round a body at rest at a known place, all measurements are the same whichever way the robot
// looks: its heading is dead reckoning.
TEST(PoseFilter, WithoutAYawThereIsNoBeginningAndAHeadingThatIsToldGetsLostAsTheCovarianceSays) {
  constexpr int flights = 40;
  double early = 0.0, late = 0.0, squares = 0.0;
  std::vector<Measurement> arrived;
  for (int i = 0; i < flights; ++i) {
    SyntheticFlight flight({.seed = static_cast<std::uint64_t>(i), .yaw = false, .hovers = true});
    const auto filter = make_pose_filter(by_heading, flight.o.mount);
    const auto until = [&](double t) {
      while (flight.now() < t) {
        filter->advance(flight.advance(arrived));
        for (Measurement& z : arrived) {
          z.p_other = flight.target(z.stamp).p, z.P_other = identity<4>(1e-8);
          filter->take(z);
        }
      }
      return filter->estimate();
    };
    EXPECT_FALSE(until(1.0).known);
    filter->start(flight.own().p, flight.own().psi, identity<4>(1e-4));
    early += until(8.0).P(3, 3);
    const PoseEstimate estimate = until(20.0);
    late += estimate.P(3, 3), squares += square(test::pose_error(estimate, flight.own())(3, 0));
  }
  EXPECT_GT(std::sqrt(late / early), 2.0);
  EXPECT_NEAR(std::sqrt(late / squares), 1.0, 0.3);
}

TEST(PoseFilter, ACompassIsAHeading) {
  for (const FilterOptions& options : {by_heading, by_attitude}) {
    SyntheticFlight flight({.seed = 6, .yaw = false});
    const auto filter = make_pose_filter(options, flight.o.mount);
    std::vector<Measurement> arrived;
    RandomStream noise(1, StreamId::draw, 1);
    double worst = 0.0;
    while (flight.now() < 10.0) {
      filter->advance(flight.advance(arrived));
      for (const Measurement& z : arrived) filter->take(z);
      filter->take({.of = Measures::heading,
                    .stamp = flight.now() - 0.005,
                    .source = 7,
                    .yaw = wrap(flight.own(flight.now() - 0.005).psi + 0.05 * noise.normal()),
                    .yaw_variance = 0.05 * 0.05});
      const PoseEstimate estimate = filter->estimate();
      if (flight.now() < 3.0) continue;
      ASSERT_TRUE(estimate.known);
      worst = std::max(worst, norm(estimate.p - flight.own().p));
    }
    EXPECT_LT(worst, 0.2);
  }
}

TEST(PoseFilter, MotionCaptureIsAPosition) {
  SyntheticFlight flight({.seed = 7, .blind_from = 0.0});
  const auto filter = make_pose_filter(by_heading, flight.o.mount);
  std::vector<Measurement> arrived;
  for (int k = 0; k < 500; ++k) {
    filter->advance(flight.advance(arrived));
    const double stamp = flight.now() - 0.02;
    filter->take({.of = Measures::position,
                  .stamp = stamp,
                  .source = 1,
                  .z = flight.own(stamp).p,
                  .R = identity<3>(1e-6)});
    filter->take({.of = Measures::heading,
                  .stamp = stamp,
                  .source = 2,
                  .yaw = flight.own(stamp).psi,
                  .yaw_variance = 1e-4});
  }
  ASSERT_TRUE(filter->estimate().known);
  EXPECT_LT(norm(filter->estimate().p - flight.own().p), 0.01);
}

TEST(PoseFilter, ANumberOutOfItsRangeIsRefusedByName) {
  EXPECT_EQ(refusal_of([] { FilterOptions{.velocity_noise = 0.0}.check(); }),
            "estimate.velocity_noise = 0, expected > 0 m/s");
  EXPECT_EQ(refusal_of([] { FilterOptions{.start_sightings = 0}.check(); }),
            "estimate.start_sightings = 0, expected 1 to 32");
}

}  // namespace
}  // namespace sightline
