#include "sightline/estimate/joint_filter.hpp"

#include <gtest/gtest.h>

#include "sightline/estimate/delayed.hpp"
#include "tests/support/counted_new.hpp"
#include "tests/support/filter_derivatives.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/synthetic_chain.hpp"

namespace sightline {
namespace {

using test::Consistency;
using test::fly_chain;
using test::fly_jointly;
using test::SeenRobot;
using test::SyntheticChain;
using test::SyntheticFlight;

TEST(JointFilter, OfOneRobotItIsTheHeadingFilter) {
  SyntheticFlight flight({.seed = 1, .outliers = 0.1, .flips = 0.1});
  const auto alone = make_pose_filter({}, flight.o.mount);
  JointFilter joint({}, std::vector{flight.o.mount});
  std::vector<Measurement> arrived;
  while (flight.now() < 6.0) {
    const MotionSample u = flight.advance(arrived);
    alone->advance(u);
    joint.advance({&u, 1});
    for (const Measurement& z : arrived) EXPECT_EQ(joint.take(0, z).verdict, alone->take(z).verdict);
    const PoseEstimate a = alone->estimate(), b = joint.estimate(0);
    ASSERT_EQ(a.known, b.known);
    ASSERT_LE(norm(a.p - b.p), 1e-9);
    ASSERT_LE(test::greatest(a.P - b.P), 1e-9);
  }
  EXPECT_TRUE(joint.estimate(0).known);
}

TEST(JointFilter, EachRobotOfAChainIsAsSureAsItMayBe) {
  const std::vector<Consistency> flown = fly_jointly({}, 5, 16, 25.0);
  for (std::size_t i = 1; i < flown.size(); ++i) {
    EXPECT_GT(flown[i].anees(), 2.8) << i;
    EXPECT_LT(flown[i].anees(), 5.0) << i;
    EXPECT_EQ(flown[i].unknown, 0) << i;
  }
  EXPECT_LT(flown[4].rmse(), 0.045);
}

TEST(JointFilter, ACircleIsNoHarmWhereAllIsKnownInOnePlace) {
  const std::vector<Consistency> flown = fly_jointly({}, 3, 16, 20.0, {{1, 0}, {2, 1}, {1, 2}});
  EXPECT_LT(flown[1].anees(), 5.2);
  EXPECT_LT(flown[2].anees(), 5.2);
}

TEST(JointFilter, OutliersDoNoHarm) {
  const std::vector<Consistency> flown = fly_jointly({.outliers = 0.2, .flips = 0.2}, 4, 8, 20.0);
  for (std::size_t i = 1; i < flown.size(); ++i) EXPECT_LT(flown[i].anees(), 5.2) << i;
}

// Between computers: each robot hears what the one before it says of itself.
TEST(ChainFilter, RobotsThatTellEachOtherTheirEstimatesDoNotCountThemTwice) {
  const std::vector<Consistency> lasting = fly_chain({}, 5, OtherError::lasting, 16, 25.0),
                                 fresh = fly_chain({}, 5, OtherError::fresh, 16, 25.0);
  for (std::size_t i = 1; i < lasting.size(); ++i) {
    EXPECT_GT(lasting[i].anees(), 2.8) << i;
    EXPECT_LT(lasting[i].anees(), 5.2) << i;
  }
  EXPECT_GT(fresh[4].anees(), 15.0) << "errors that last, taken for fresh ones, are averaged away";
}

TEST(ChainFilter, IntersectionIsTrueInACircleAndFarLessSure) {
  const std::vector<std::pair<int, int>> circle = {{1, 0}, {2, 1}, {1, 2}};
  const std::vector<Consistency> flown = fly_chain({}, 3, OtherError::unknown, 8, 20.0, circle);
  EXPECT_LT(flown[1].anees(), 4.6);
  EXPECT_LT(flown[2].anees(), 4.6);
  EXPECT_LT(flown[1].rmse(), 0.03);
}

TEST(ChainFilter, TheCovarianceGoesOnAsTheStateDoesAndInnovationsAsHSays) {
  constexpr SensorMount mount{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::body};
  const ChainFilter filter({}, mount);
  Random random(1);
  const auto s = test::random_state(filter, random);
  const MotionSample u = test::random_motion(random);
  Measurement z = test::random_sighting(random);
  z.other_error = OtherError::lasting;
  const Innovation<4, ChainFilter::n> of = filter.innovation(s, z, u);
  constexpr double h = 1e-6;
  for (int i = 0; i < ChainFilter::n; ++i) {
    const auto before = filter.innovation(test::moved(filter, s, i, -h), z, u);
    const auto after = filter.innovation(test::moved(filter, s, i, h), z, u);
    for (int a = 0; a < 4; ++a)
      EXPECT_NEAR(-wrap(after.y(a, 0) - before.y(a, 0)) / (2 * h), of.H(a, i), 1e-6) << a << " by " << i;
  }
  EXPECT_LT(of.R(0, 0), filter.innovation(s, test::random_sighting(random), u).R(0, 0) + 1.0);
  // The error of the other is as likely as it tells, after a while.
  auto later = s;
  filter.hear(later, z);
  for (int k = 0; k < 2000; ++k) filter.advance(later, u, 0.01);
  EXPECT_LE(test::greatest(block<4, 4>(later.P, 10, 10) - z.P_other), 1e-6);
}

TEST(JointFilter, LateMeasurementsLeaveTheStateThatTheyWouldInTime) {
  struct Heard {
    double arrival;
    SeenRobot seen;
  };
  SyntheticChain chain({.seed = 3, .latency_min = 0.0, .latency_max = 0.0}, 4);
  const SensorMount mount = test::SyntheticOptions{}.mount;
  const std::vector<SensorMount> mounts(3, mount);
  JointFilter in_time({}, mounts), late({}, mounts);
  BroadcastTrack anchor({.sighting_rate = 30});
  std::vector<MotionSample> motion;
  std::vector<SeenRobot> arrived;
  std::vector<Heard> waiting;
  const auto complete = [&](SeenRobot& seen) {
    const auto pose = anchor.at(seen.z.stamp);
    if (seen.target != 0) return true;
    if (!pose) return false;
    seen.z.p_other = pose->p, seen.z.psi_other = pose->psi, seen.z.P_other = pose->P;
    return true;
  };
  while (chain.now() < 4.0) {
    chain.advance(motion, arrived);
    in_time.advance(std::span(motion).subspan(1));
    late.advance(std::span(motion).subspan(1));
    anchor.take(chain.anchor());
    for (SeenRobot& seen : arrived) {
      if (!complete(seen) || chain.now() > 3.5) continue;
      in_time.take(seen.observer - 1, seen.z, seen.target - 1);
      // All have begun by then; later ones come out of order.
      const double lag = chain.now() < 1.0 ? 0.0 : 0.1 * (1 + seen.observer % 2);
      waiting.push_back({chain.now() + lag, seen});
    }
    std::erase_if(waiting, [&](const Heard& h) {
      if (h.arrival > chain.now()) return false;
      late.take(h.seen.observer - 1, h.seen.z, h.seen.target - 1);
      return true;
    });
  }
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(in_time.estimate(i).known);
    EXPECT_LE(norm(in_time.estimate(i).p - late.estimate(i).p), 1e-12) << i;
    EXPECT_LE(test::greatest(in_time.covariance(i, 0) - late.covariance(i, 0)), 1e-12) << i;
  }
}

TEST(JointFilter, ItAllocatesNothingOnceItIsMadeAndRefusesWhatItCannotUse) {
  SyntheticChain chain({.seed = 4}, 4);
  JointFilter filter({}, std::vector<SensorMount>(3, test::SyntheticOptions{}.mount));
  std::vector<MotionSample> motion;
  std::vector<SeenRobot> arrived;
  BroadcastTrack anchor;
  std::int64_t allocations = 0;
  while (chain.now() < 3.0) {
    chain.advance(motion, arrived);
    anchor.take(chain.anchor());
    for (SeenRobot& seen : arrived)
      if (const auto pose = anchor.at(seen.z.stamp); pose && seen.target == 0)
        seen.z.p_other = pose->p, seen.z.psi_other = pose->psi, seen.z.P_other = pose->P;
    const std::int64_t before = allocations_here();
    filter.advance(std::span(motion).subspan(1));
    for (const SeenRobot& seen : arrived) filter.take(seen.observer - 1, seen.z, seen.target - 1);
    allocations += allocations_here() - before;
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_TRUE(filter.estimate(2).known);
  Random random(1);
  const Measurement z = test::random_sighting(random);
  EXPECT_EQ(filter.take(3, z).verdict, FitVerdict::unusable) << "a robot that is none";
  EXPECT_EQ(filter.take(1, z, 1).verdict, FitVerdict::unusable) << "itself";
  EXPECT_EQ(refusal_of([] { return JointFilter({}, {}); }),
            "a joint filter has no robot, expected at least one");
}

}  // namespace
}  // namespace sightline
