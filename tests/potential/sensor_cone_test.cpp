#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"

namespace sightline {

void PrintTo(ConeForm form, std::ostream* to) { *to << (form == ConeForm::sine ? "sine" : "tangent"); }

namespace {

SensorCone random_cone(Random& random, ConeForm form) {
  return {.alpha = uniform(random, 0.1, 1.4),
          .kappa_G = uniform(random, 0.001, 0.1),
          .kappa_A = uniform(random, 0.5, 20),
          .form = form,
          .mount = random_mount(random)};
}

/// The angle from the axis within which the unit step is zero.
double half_angle(const SensorCone& cone) {
  return cone.form == ConeForm::sine ? std::atan(std::sin(cone.alpha)) : cone.alpha;
}

class ConeForms : public testing::TestWithParam<ConeForm> {
 protected:
  Random random_{1};
};
INSTANTIATE_TEST_SUITE_P(Both, ConeForms, testing::Values(ConeForm::sine, ConeForm::tangent));

TEST_P(ConeForms, WithoutSlopeTheUnitStepIsZeroInTheConeAndOneOutside) {
  int seen = 0;
  for (int k = 0; k < 20'000; ++k) {
    SensorCone cone = random_cone(random_, GetParam());
    cone.kappa_G = 0;
    const Pose<double> observer = random_pose(random_, 3), target = random_pose(random_, 3);
    const bool in_view = view_angle(cone.mount, observer, target.p) <= half_angle(cone);
    EXPECT_EQ(cone.over(UnitStep{}, observer, target), in_view ? 0.0 : 1.0);  // (30)
    seen += in_view;
  }
  EXPECT_GT(seen, 1000);
}

TEST_P(ConeForms, TheEdgeOfTheConeIsAtItsHalfAngle) {
  for (int k = 0; k < 1000; ++k) {
    SensorCone cone = random_cone(random_, GetParam());
    cone.mount = {0.0, 0.0};
    const double edge = half_angle(cone), far = uniform(random_, 0.1, 5);
    const auto at = [&](double angle) {
      const Pose<double> target{{far * std::cos(angle), far * std::sin(angle), 0.0}, {1.0, 0.0}};
      return cone.over(UnitStep{}, Pose<double>{{}, {1.0, 0.0}}, target);
    };
    EXPECT_EQ(at(edge - 1e-9), 0.0);
    EXPECT_GT(at(edge + 1e-9), 0.99);
  }
}

/// l of a target at (x, off) of the plane of the sensor's axis, the robot level at the origin.
double at(const SensorCone& cone, double x, double off) {
  SensorCone level = cone;
  level.mount = {0.0, 0.0};
  return level(Sight<double>{{{}, {1.0, 0.0}}, {}}, Sight<double>{{{x, off, 0.0}, {1.0, 0.0}}, {}});
}

TEST_P(ConeForms, NearerToTheAxisIsAlwaysCheaper) {
  for (int k = 0; k < 5000; ++k) {
    const SensorCone cone = random_cone(random_, GetParam());
    const double x = uniform(random_, -5, 5), off = uniform(random_, 0.01, 5);
    EXPECT_LT(at(cone, x, 0.99 * off), at(cone, x, off));
  }
}

TEST_P(ConeForms, FarOutOfViewTheSlopeStillLeadsBackAndWithoutItNothingDoes) {
  for (int k = 0; k < 1000; ++k) {
    SensorCone cone = random_cone(random_, GetParam());
    cone.kappa_A = 10;
    const double x = uniform(random_, -1, 1), off = uniform(random_, 10, 100);
    EXPECT_GT(at(cone, x, off) - at(cone, x, off - 0.1), 0.05 * cone.kappa_G * off);
    cone.kappa_G = 0;  // (33)
    EXPECT_NEAR(at(cone, x, off), at(cone, x, off - 0.1), 1e-15);
  }
}

}  // namespace
}  // namespace sightline
