#include <gtest/gtest.h>

#include "sightline/estimate/heading_filter.hpp"
#include "sightline/estimate/out_of_sequence_filter.hpp"
#include "tests/support/filter_derivatives.hpp"
#include "tests/support/synthetic_chain.hpp"

namespace sightline {
namespace {

using test::Consistency;
using test::fly_chain;

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
  filter.receive(later, z);
  for (int k = 0; k < 2000; ++k) filter.advance(later, u, 0.01);
  EXPECT_LE(test::greatest(block<4, 4>(later.P, 10, 10) - z.P_other), 1e-6);
}

}  // namespace
}  // namespace sightline
