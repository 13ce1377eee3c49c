#include "sightline/estimate/out_of_sequence_filter.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>
#include <vector>

#include "sightline/estimate/attitude_filter.hpp"
#include "sightline/estimate/heading_filter.hpp"
#include "tests/support/counted_new.hpp"
#include "tests/support/filter_derivatives.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/synthetic_flight.hpp"

namespace sightline {
namespace {

using test::SyntheticFlight;
using test::SyntheticOptions;

/// A flight as it happened: the motion of each period, and each measurement with the end of the
/// period that its stamp falls into.
struct Happened {
  std::vector<MotionSample> motion;
  std::vector<Measurement> measured;
};
Happened occurred(SyntheticOptions options, double duration) {
  options.dropout = 0.0;
  SyntheticFlight flight(options);
  Happened all;
  std::vector<Measurement> arrived;
  while (flight.now() < duration) {
    all.motion.push_back(flight.advance(arrived));
    all.measured.insert(all.measured.end(), arrived.begin(), arrived.end());
  }
  return all;
}

/// Each measurement arrives with the sample that holds its stamp, and so many samples later.
template <class Filter, class Late>
std::unique_ptr<OutOfSequenceFilter<Filter>> filtered(const Happened& all, const FilterOptions& options,
                                                      const Late& late) {
  const SensorMount mount = SyntheticOptions{}.mount;
  auto filter = std::make_unique<OutOfSequenceFilter<Filter>>(options, Filter(options, mount));
  std::vector<std::vector<Measurement>> arriving(all.motion.size());
  for (std::size_t i = 0; i < all.measured.size(); ++i) {
    const Measurement& z = all.measured[i];
    std::size_t k = 0;
    while (all.motion[k].t + all.motion[k].dt <= z.stamp) ++k;
    // The first ones, by which an estimate begins, in order.
    k += z.stamp < 0.5 ? 0 : static_cast<std::size_t>(late(i));
    if (k < arriving.size()) arriving[k].push_back(z);
  }
  for (std::size_t k = 0; k < all.motion.size(); ++k) {
    filter->advance(all.motion[k]);
    for (const Measurement& z : arriving[k]) filter->take(z);
  }
  return filter;
}

template <class Filter>
void expect_same(const OutOfSequenceFilter<Filter>& a, const OutOfSequenceFilter<Filter>& b) {
  ASSERT_TRUE(a.estimate().known && b.estimate().known);
  EXPECT_LE(test::greatest(test::difference(a.state(), b.state())), 1e-12);
  EXPECT_LE(test::greatest(a.state().P - b.state().P), 1e-12);
  EXPECT_EQ(a.estimate().p.x, b.estimate().p.x) << "bit for bit";
}

template <class Filter>
void expect_lateness_does_not_matter(SyntheticOptions synthetic) {
  // It ends with 0.4 s without pictures, so that the latest arrive too.
  synthetic.blind_from = 3.6;
  const Happened all = occurred(synthetic, 4.0);
  ASSERT_GT(all.measured.size(), 90U);
  const FilterOptions options{.correlation_time = synthetic.correlation_time};
  const auto in_order = filtered<Filter>(all, options, [](std::size_t) { return 0; });
  expect_same(*in_order, *filtered<Filter>(all, options, [](std::size_t) { return 8; }));
  // Out of order, up to 0.37 s late.
  expect_same(*in_order, *filtered<Filter>(all, options, [](std::size_t i) { return (i * 17) % 38; }));
}

TEST(OutOfSequenceFilter, AMeasurementThatIs80MsLateOrOutOfOrderLeavesTheStateThatItWouldInTime) {
  expect_lateness_does_not_matter<HeadingFilter>({.seed = 1});
  expect_lateness_does_not_matter<AttitudeFilter>({.seed = 2});
}

TEST(OutOfSequenceFilter, TheSameHoldsAmongOutliersAndFlips) {
  expect_lateness_does_not_matter<HeadingFilter>({.seed = 3, .outliers = 0.2, .flips = 0.2});
  expect_lateness_does_not_matter<AttitudeFilter>({.seed = 4, .outliers = 0.2, .flips = 0.2});
}

TEST(OutOfSequenceFilter, TheSameHoldsWithCorrelatedErrors) {
  expect_lateness_does_not_matter<HeadingFilterOf<0, 1>>({.seed = 5, .correlation_time = 2.0});
  expect_lateness_does_not_matter<AttitudeFilterOf<1>>({.seed = 6, .correlation_time = 2.0});
}

TEST(OutOfSequenceFilter, AMeasurementOfAnUnknownPastOrTheFutureIsNotTakenAndOneCountsOnce) {
  const Happened all = occurred({.seed = 5, .blind_from = 1.5}, 2.0);
  const auto filter = filtered<HeadingFilter>(all, {}, [](std::size_t) { return 0; });
  Measurement z = all.measured.back();
  ASSERT_LT(z.stamp, 1.5);
  const double before = filter->estimate().P(0, 0);
  EXPECT_EQ(filter->take(z).verdict, FitVerdict::repeated);
  z.source = 1;
  EXPECT_EQ(filter->take(z).verdict, FitVerdict::accepted) << "of another source it is another one";
  EXPECT_LT(filter->estimate().P(0, 0), before);
  z.stamp = 1.3;
  EXPECT_EQ(filter->take(z).verdict, FitVerdict::too_old);
  z.stamp = 2.2;
  EXPECT_EQ(filter->take(z).verdict, FitVerdict::unusable);
  z = all.measured.back();
  z.R(0, 0) = -1;
  EXPECT_EQ(filter->take(z).verdict, FitVerdict::unusable);
}

TEST(OutOfSequenceFilter, OneAheadOfTheMotionIsTakenWithTheSampleItFallsInto) {
  const Happened all = occurred({.seed = 6}, 2.0);
  auto in_order = filtered<HeadingFilter>(all, {}, [](std::size_t) { return 0; });
  auto early = filtered<HeadingFilter>(all, {}, [](std::size_t) { return 0; });
  MotionSample next = all.motion.back();
  next.t += next.dt;
  Measurement z = all.measured.back();
  z.stamp = next.t + 0.004;
  EXPECT_EQ(early->take(z).verdict, FitVerdict::pending);
  early->advance(next);
  in_order->advance(next);
  in_order->take(z);
  expect_same(*in_order, *early);
}

TEST(OutOfSequenceFilter, ManyMoreMeasurementsThanItRemembersAreAllUsed) {
  // 900 Hz: 64 of them are 70 ms.
  const Happened all = occurred({.seed = 7, .camera_rate = 900, .blind_from = 1.9}, 2.0);
  const auto in_order = filtered<HeadingFilter>(all, {}, [](std::size_t) { return 0; });
  const auto late = filtered<HeadingFilter>(all, {}, [](std::size_t) { return 5; });
  expect_same(*in_order, *late);
  const auto few = filtered<HeadingFilter>(occurred({.seed = 7, .blind_from = 1.9}, 2.0), {},
                                           [](std::size_t) { return 0; });
  EXPECT_LT(in_order->estimate().position_sigma(), few->estimate().position_sigma());
}

TEST(OutOfSequenceFilter, AMotionThatNobodyMeasuredWidensTheEstimate) {
  const Happened all = occurred({.seed = 8}, 2.0);
  auto filter = filtered<HeadingFilter>(all, {}, [](std::size_t) { return 0; });
  auto gapped = filtered<HeadingFilter>(all, {}, [](std::size_t) { return 0; });
  MotionSample next = all.motion.back();
  for (int k = 1; k <= 50; ++k) {
    next.t += 0.01;
    filter->advance(next);
  }
  gapped->advance(next);
  EXPECT_EQ(gapped->estimate().stamp, filter->estimate().stamp);
  EXPECT_GT(gapped->estimate().position_sigma(), filter->estimate().position_sigma() + 0.1);
  EXPECT_GT(gapped->estimate().heading_sigma(), filter->estimate().heading_sigma() + 0.1);
  const double stamp = filter->estimate().stamp;
  next.v_V.x = not_a_number;
  next.t += 0.01;
  filter->advance(next);
  EXPECT_EQ(filter->estimate().stamp, stamp) << "a sample that is not finite is none";
}

/// A filter of a robot at rest at the origin that looks along x, and sightings of a body at rest.
class Resting {
 public:
  OutOfSequenceFilter<HeadingFilter> filter{{}, HeadingFilter({}, {.frame = MountFrame::level})};

  /// Sighting from p and psi, in the last sample; it tells the heading psi + turned.
  Measurement sighting(const Vec3<double>& p = {}, double psi = 0.0, double turned = 0.0) const {
    const Vec3<double> other = {2, 0.5, 1};
    Measurement z{.stamp = t_ - 0.005, .z = turn_z(-psi) * (other - p), .R = identity<3>(1e-4)};
    z.has_yaw = true, z.yaw = wrap(-psi - turned), z.yaw_variance = 1e-4;
    z.p_other = other, z.P_other = identity<4>(1e-6);
    return z;
  }
  void advance() {
    filter.advance({.t = t_, .dt = 0.01});
    t_ += 0.01;
  }
  FitVerdict see(const Vec3<double>& p = {}, double psi = 0.0, double turned = 0.0) {
    advance();
    return filter.take(sighting(p, psi, turned)).verdict;
  }
  void settle() {
    for (int k = 0; k < 20; ++k) see();
    ASSERT_TRUE(filter.estimate().known);
  }

 private:
  double t_ = 0.0;
};

TEST(OutOfSequenceFilter, TheThirdSightingThatAgreesStartsItAndCountsOnceAndForgottenItStartsAnew) {
  Resting robot;
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(robot.see(), FitVerdict::waiting);
    EXPECT_EQ(robot.see({0.5, 0, 0}), FitVerdict::waiting) << "it means another place";
    EXPECT_EQ(robot.see(), FitVerdict::waiting);
    EXPECT_FALSE(robot.filter.estimate().known);
    EXPECT_EQ(robot.see(), FitVerdict::started);
    EXPECT_TRUE(robot.filter.estimate().known);
    const Mat<4, 4> before = robot.filter.estimate().P;
    EXPECT_EQ(robot.filter.take(robot.sighting()).verdict, FitVerdict::too_old);
    EXPECT_EQ(robot.filter.estimate().P, before);
    robot.filter.forget();
  }
}

TEST(OutOfSequenceFilter, EightContradictionsInARowRestartItAndAnAcceptedOneBetweenThemForgetsThem) {
  const auto contradict = [](const Vec3<double>& p, double turned, FitVerdict meanwhile) {
    Resting robot;
    robot.settle();
    for (int round = 0; round < 3; ++round) {
      for (int k = 0; k < 7; ++k) EXPECT_EQ(robot.see(p, 0.0, turned), meanwhile) << round << ", " << k;
      EXPECT_EQ(robot.see(), FitVerdict::accepted) << round;
    }
    for (int k = 0; k < 7; ++k) EXPECT_EQ(robot.see(p, 0.0, turned), meanwhile) << k;
    EXPECT_EQ(robot.see(p, 0.0, turned), FitVerdict::restarted);
    EXPECT_NEAR(robot.filter.estimate().psi, turned, 1e-3);
  };
  contradict({1, -1, 0}, 0.0, FitVerdict::rejected);
  contradict({}, 1.0, FitVerdict::accepted_position);
}

TEST(OutOfSequenceFilter, ACompassTellsTheHeadingOfSightingsWithoutOneForASecondAndAHalf) {
  for (const bool old : {false, true}) {
    Resting robot;
    robot.advance();
    Measurement compass{.of = Measures::heading, .stamp = 0.005, .source = -1};
    compass.yaw = 0.0, compass.yaw_variance = 1e-4;
    EXPECT_EQ(robot.filter.take(compass).verdict, FitVerdict::waiting);
    for (int k = 0; k < (old ? 160 : 130); ++k) robot.advance();
    FitVerdict last = FitVerdict::waiting;
    for (int k = 0; k < 3; ++k) {
      robot.advance();
      Measurement z = robot.sighting();
      z.has_yaw = false;
      last = robot.filter.take(z).verdict;
    }
    EXPECT_EQ(last, old ? FitVerdict::waiting : FitVerdict::started);
  }
}

TEST(OutOfSequenceFilter, ALateOneIsNotTheLastThatWasAccepted) {
  Resting robot;
  robot.settle();
  const double last = robot.filter.estimate().last_accepted;
  Measurement late = robot.sighting();
  late.stamp -= 0.03, late.source = 1;
  EXPECT_EQ(robot.filter.take(late).verdict, FitVerdict::accepted);
  EXPECT_EQ(robot.filter.estimate().last_accepted, last);
}

TEST(OutOfSequenceFilter, NothingIsAllocatedOnceItIsMade) {
  for (const FilterOptions& options :
       {FilterOptions{}, FilterOptions{.correlation_time = 2.0},
        FilterOptions{.filter = FilterKind::attitude},
        FilterOptions{.filter = FilterKind::attitude, .correlation_time = 2.0}}) {
    const Happened all = occurred({.seed = 9, .outliers = 0.3, .flips = 0.3}, 3.0);
    const auto filter = make_pose_filter(options, SyntheticOptions{}.mount);
    const std::int64_t before = allocations_here();
    for (const MotionSample& u : all.motion) {
      filter->advance(u);
      for (const Measurement& z : all.measured)
        if (z.stamp >= u.t - 0.1 && z.stamp < u.t) filter->take(z);
      filter->estimate();
    }
    filter->start({}, 0.0, identity<4>());
    filter->forget();
    EXPECT_EQ(allocations_here(), before);
  }
  EXPECT_GT(allocations_here(), 0) << "they are counted";
}

}  // namespace
}  // namespace sightline
