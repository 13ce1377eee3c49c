#include "sightline/estimate/agreement.hpp"

#include <gtest/gtest.h>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// What a robot on a circle means at a time, and its dead reckoning, in a frame turned by a radian
/// and moved.
PoseHypothesis on_circle(double t) {
  const auto place = [](double s) { return Vec3<double>{std::cos(s), std::sin(s), 1.0}; };
  PoseHypothesis m{
      .stamp = t, .p = place(t), .psi = wrap(t + 0.5 * std::numbers::pi), .sigma = 0.01, .psi_sigma = 0.01};
  m.reckoned.p = turn_z(1.0) * m.p + Vec3<double>{5, -3, 2};
  m.reckoned.psi = wrap(m.psi + 1.0);
  return m;
}

TEST(Agreement, AllThatOneMovingRobotMeansAgrees) {
  Agreement agreement;
  for (int k = 0; k < 20; ++k) EXPECT_EQ(agreement.add(on_circle(10 + 0.05 * k)), k + 1);
}

TEST(Agreement, WhatMeansAnotherPlaceOrHeadingDoesNotCount) {
  Agreement agreement;
  EXPECT_EQ(agreement.add(on_circle(1.0)), 1);
  PoseHypothesis elsewhere = on_circle(1.1);
  elsewhere.p.x += 0.5;
  EXPECT_EQ(agreement.add(elsewhere), 1);
  PoseHypothesis turned = on_circle(1.2);
  turned.psi += 0.5;
  EXPECT_EQ(agreement.add(turned), 1);
  EXPECT_EQ(agreement.add(on_circle(1.3)), 2);
  elsewhere = on_circle(1.4);
  elsewhere.p.x += 0.5;
  elsewhere.sigma = 0.2;
  EXPECT_EQ(agreement.add(elsewhere), 4) << "one that is not sure of its place agrees with those around it";
}

TEST(Agreement, WhatIsLongAgoDoesNotCount) {
  Agreement agreement;
  agreement.add(on_circle(1.0));
  EXPECT_EQ(agreement.add(on_circle(1.0 + Agreement::window + 0.01)), 1);
  agreement.clear();
  EXPECT_EQ(agreement.add(on_circle(2.6)), 1);
}

TEST(Agreement, MoreThanItRemembersAreNoFault) {
  Agreement agreement;
  int agreeing = 0;
  for (int k = 0; k < 200; ++k) agreeing = agreement.add(on_circle(0.01 * k));
  EXPECT_EQ(agreeing, static_cast<int>(Agreement::memory) + 1);
}

TEST(Agreement, DeadReckoningIsTheMotionItIsTold) {
  DeadReckoning reckoned;
  MotionSample u{.v_V = {1, 0, 0.5}, .yaw_rate = 1.0};
  for (int k = 0; k < 62832; ++k) reckoned.advance(u, 1e-4);
  EXPECT_LE(norm(reckoned.p - Vec3<double>{0, 0, 0.5 * 6.2832}), 1e-3);
  EXPECT_NEAR(reckoned.psi, 0.0, 1e-4);
}

}  // namespace
}  // namespace sightline
