#include "sightline/analysis/verdict.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

const VerdictOptions quick = {.samples = 20'000};

Region softplus_cone() {
  return Region("bearing < half", {{"half", std::atan(std::sin(0.5))}})
      .slope(Softplus{})
      .sigmoid(5.0)
      .seen_from({});
}
Region softplus_cohesion() { return Region("distance < 2 m").slope(Softplus{}).sigmoid(3.0); }

TEST(Verdict, ThePapersConeHasNoGradientInYawBehindTheSensorAndAnotherHalfAngle) {
  const Verdict v = judge(SensorCone{});
  EXPECT_GT(v.flat_in_yaw_behind, 0.95);
  EXPECT_THAT(v.warnings, Contains(HasSubstr("no gradient in yaw behind the sensor")));
  ASSERT_TRUE(v.of_step && v.of_limit);
  EXPECT_NEAR(v.of_step->least, 0.447, 5e-4);
  EXPECT_NEAR(v.of_step->greatest, 0.447, 5e-4);
  EXPECT_NEAR(v.of_limit->greatest, 0.5, 1e-9);
  EXPECT_THAT(v.warnings, Contains(HasSubstr("0.447 rad, not the 0.500 rad")));
  EXPECT_GT(v.step_disagrees, 0.005);
}

TEST(Verdict, ASoftplusConeTurnsTheObserverFromBehind) {
  const Verdict v = judge(softplus_cone());
  EXPECT_LT(v.flat_in_yaw_behind, 0.1);
  EXPECT_EQ(v.turns_away, 0.0);
  EXPECT_EQ(v.traps_in_yaw, 0.0);
  ASSERT_TRUE(v.of_step && v.of_limit);
  EXPECT_NEAR(v.of_step->greatest, v.of_limit->greatest, 1e-6);
  EXPECT_EQ(v.step_disagrees, 0.0);
  for (const char* word : {"no gradient in yaw", "half-angle", "disagree"}) {
    EXPECT_THAT(v.warnings, Not(Contains(HasSubstr(word))));
  }
}

TEST(Verdict, ThePapersCohesionVanishesBeyondTwoAndAHalfMetresAndSoftplusDoesNot) {
  const Verdict paper = judge(Cohesion{}), ours = judge(softplus_cohesion());
  ASSERT_TRUE(paper.flat_beyond);
  EXPECT_NEAR(*paper.flat_beyond, 2.5, 0.11);
  EXPECT_THAT(paper.warnings, Contains(HasSubstr("vanishes beyond 2.5 m")));
  EXPECT_FALSE(ours.flat_beyond);
  EXPECT_EQ(ours.flat_in_position, 0.0);
  EXPECT_THAT(ours.warnings, testing::IsEmpty());
}

TEST(Verdict, KnowsTheConeOfAnyHalfAngleInBothForms) {
  Random random(1);
  for (int n = 0; n < 10; ++n) {
    const double alpha = uniform(random, 0.1, 1.3);
    const Verdict sine = judge(SensorCone{.alpha = alpha}, quick);
    const Verdict tangent = judge(SensorCone{.alpha = alpha, .form = ConeForm::tangent}, quick);
    EXPECT_NEAR(sine.of_step->greatest, std::atan(std::sin(alpha)), 1e-6);
    EXPECT_NEAR(tangent.of_step->greatest, alpha, 1e-6);
    EXPECT_NEAR(tangent.of_limit->greatest, alpha, 1e-6);
    EXPECT_EQ(tangent.step_disagrees, 0.0);
  }
}

TEST(Verdict, TheShareOutsideIsTheVolumeOutside) {
  for (const double d : {1.0, 2.0, 4.0}) {
    const double ball = std::pow(d / 6.0, 3);
    EXPECT_NEAR(judge(KeepOut{.d_min = d}, quick).outside, ball, 2e-3);
    EXPECT_NEAR(judge(Cohesion{.d_max = d}, quick).outside, 1 - ball, 2e-3);
  }
}

/// A keep-out whose step is at 1.2 m, though its limit is at 1 m.
struct Shifted {
  KeepOut inner{.d_min = 1.2};

  template <class Step, class S>
  S over(const Step& eps, const Pose<S>& a, const Pose<S>& b) const {
    return inner.over(eps, a, b);
  }
  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return inner(a, b);
  }
  double violation(const Sight<double>& a, const Sight<double>& b) const { return 1.0 - norm(a.p - b.p); }
};

TEST(Verdict, MeasuresHowFarAStepIsFromItsLimit) {
  const Verdict v = judge(Shifted{});
  EXPECT_NEAR(v.bias, -0.2, 1e-3) << "it is felt 0.2 m before the limit is broken";
  EXPECT_NEAR(v.bias_worst, -0.2, 1e-3);
  EXPECT_NEAR(v.step_disagrees, (std::pow(1.2, 3) - 1) / std::pow(6.0, 3), 1e-3);
  EXPECT_NEAR(judge(KeepOut{}).bias_worst, 0.0, 1e-6);
  EXPECT_NEAR(judge(Cohesion{}).bias_worst, 0.0, 1e-6);
}

/// Pulls to the origin and, less, to a place behind, which its limit forbids.
struct TwoWells {
  template <class S>
  S operator()(const Sight<S>& observer, const Sight<S>& target) const {
    const Vec3<S> r = target.p - observer.p;
    const Vec3<S> q = r - Vec3<S>{-2.0, 1.0, 0.5};
    return 0.1 * dot(r, r) - exp(-dot(r, r)) - exp(-2.0 * dot(q, q));
  }
  double violation(const Sight<double>& a, const Sight<double>& b) const { return norm(a.p - b.p) - 1.0; }
};

TEST(Verdict, FindsALocalMinimumOutsideTheLimitAndOnlyThere) {
  const Verdict v = judge(TwoWells{}, quick);
  ASSERT_EQ(v.traps.size(), 1u);
  EXPECT_LE(norm(v.traps[0].p_S - Vec3<double>{-2.0, 1.0, 0.5}), 0.2);
  EXPECT_THAT(v.warnings, Contains(HasSubstr("local minimum outside its limit")));
  EXPECT_TRUE(judge(KeepOut{}, quick).traps.empty());
}

TEST(Verdict, SaysWhereAFormTurnsTheObserverAway) {
  // hypot(y, z) < x tan(half): behind the sensor it pulls into the mirror image of the cone.
  const Region mirrored =
      Region("hypot(y, z) < x * tan(half)", {{"half", 0.447}}).slope(Softplus{}).sigmoid(5.0).seen_from({});
  const Verdict v = judge(mirrored);
  EXPECT_GT(v.turns_away, 0.2);
  EXPECT_GT(v.traps_in_yaw, 0.2);
  EXPECT_THAT(v.warnings, Contains(HasSubstr("away from its target")));
}

TEST(Verdict, StiffnessGrowsWithTheSharpness) {
  double before = 0.0;
  for (const double kappa_A : {1.0, 3.0, 10.0, 30.0}) {
    const Verdict v = judge(KeepOut{.kappa_A = kappa_A}, quick);
    EXPECT_GT(v.curvature_worst, before);
    before = v.curvature_worst;
  }
}

TEST(Verdict, LooksFurtherForALimitThatIsFurther) {
  const Verdict radio = judge(Region("range < 8 m").slope(Softplus{}), quick);
  EXPECT_GT(radio.options.reach, 8.0);
  EXPECT_GT(radio.outside, 0.0);
  EXPECT_GT(judge(KeepOut{.d_min = 7.0}, quick).options.reach, 7.0);
  const Verdict nowhere = judge(Cohesion{.d_max = 200.0}, quick);
  EXPECT_EQ(nowhere.outside, 0.0);
  EXPECT_THAT(nowhere.words, Contains(HasSubstr("broken nowhere within 6 m")));
}

TEST(Verdict, OfASensorThatSeesAllAboutNothingIsTurnedAway) {
  const Region ring = Region("abs(elevation) < 15 deg").slope(Softplus{}).sigmoid(10.0);
  EXPECT_EQ(judge(ring.seen_from({0.3, 0.0}), quick).turns_away, 0.0);
}

TEST(Verdict, OfAFormulaThatIsNoNumberSomewhereIsStillGiven) {
  const Verdict v = judge(Region("sqrt(x * 1 m) < 1 m").slope(Softplus{}), quick);
  EXPECT_TRUE(std::isfinite(v.level));
  EXPECT_GT(v.outside, 0.0);
}

TEST(Verdict, AsJsonHoldsItsNumbersWithRadiusAndThreshold) {
  const auto json =
      nlohmann::json::parse(to_json(judge(Cohesion{}, {.reach = 5.0, .flat = 0.02, .samples = 5000})));
  EXPECT_EQ(json.at("potential"), "cohesion");
  EXPECT_EQ(json.at("radius"), 5.0);
  EXPECT_EQ(json.at("threshold"), 0.02);
  EXPECT_TRUE(json.at("region").at("half_angle").is_null());
  EXPECT_TRUE(json.at("gradient_vanishes").at("in_yaw").is_null());
  EXPECT_GT(json.at("gradient_vanishes").at("in_position"), 0.5);
  EXPECT_GT(json.at("words").size(), json.at("warnings").size());
}

}  // namespace
}  // namespace sightline
