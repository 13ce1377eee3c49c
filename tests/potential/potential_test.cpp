#include "sightline/potential.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/difference.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/strict.hpp"

namespace sightline {
namespace {

constexpr int pair_size = 2 * sight_size;

/// l of a potential of either kind; a row holds the observer's sight, then the target's.
template <class S, class P, class Row>
S value(const P& potential, const Row& row) {
  if constexpr (PairPotential<P>) {
    return potential(sight_from<S>(row.data()), sight_from<S>(row.data() + sight_size));
  } else {
    return potential(sight_from<S>(row.data()));
  }
}

template <class Step, class P>
double over(const P& potential, const Step& step, const Sight<double>& a, const Sight<double>& b) {
  if constexpr (PairPotential<P>) {
    return potential.over(step, a, b);
  } else {
    return potential.over(step, Pose<double>(a));
  }
}

/// The potentials, with parameters at which a few metres hold both sides of their limits.
template <class P>
P example() {
  return {};
}
template <>
SensorCone example() {
  return {.form = ConeForm::tangent};  // the form whose limit is alpha itself
}
template <>
AltitudeBand example() {
  return {.z_min = -1, .z_max = 1.5};
}
template <>
Geofence example() {
  return {.low = {-2, -2, -1}, .high = {2, 1.5, 2}};
}

/// The laws of every potential; a new one is added to a list and obeys them all.
template <class P>
class PotentialLaws : public testing::Test {
 protected:
  std::array<double, pair_size> row(double reach) {
    std::array<double, pair_size> r;
    write_sight(random_sight(random_, reach), r);
    write_sight(random_sight(random_, reach), std::span(r).last(sight_size));
    return r;
  }

  P potential_ = example<P>();
  Random random_{1};
};
constexpr SensorMount sideways = {
    .pitch = 1.37, .offset = {0.1, -0.2, 0.05}, .frame = MountFrame::body, .yaw = 1.57, .roll = -0.7};
/// The views of a camera as labs mount it.
struct SideCone : SensorCone {
  SideCone() : SensorCone{.mount = sideways} {}
};
struct SideBearing : Bearing {
  SideBearing() : Bearing{.mount = sideways} {}
};
/// The views of a camera that is fixed to the body, so that they see the lean.
struct BodySensorCone : SensorCone {
  BodySensorCone()
      : SensorCone{.form = ConeForm::tangent, .mount = {.pitch = 0.3, .frame = MountFrame::body}} {}
};
struct BodyBearing : Bearing {
  BodyBearing() : Bearing{.mount = {.pitch = 0.3, .frame = MountFrame::body}} {}
};
using Potentials =
    testing::Types<SideCone, SideBearing, BodySensorCone, BodyBearing, SensorCone, KeepOut, Cohesion,
                   AltitudeBand, Geofence, Bearing, TooNear, TooFar, RelativeVelocity, PassRight>;
TYPED_TEST_SUITE(PotentialLaws, Potentials);

/// The laws of those made from inequalities by a step.
template <class P>
class StepLaws : public PotentialLaws<P> {};
using PotentialsOfSteps =
    testing::Types<BodySensorCone, SensorCone, KeepOut, Cohesion, AltitudeBand, Geofence>;
TYPED_TEST_SUITE(StepLaws, PotentialsOfSteps);

/// The laws of those that ask for a target in view, whose limit is an angle alpha.
template <class P>
class ViewLaws : public PotentialLaws<P> {
 protected:
  P any() {
    Random& random = this->random_;
    P p = this->potential_;
    p.alpha = uniform(random, 0.1, 1.4);
    p.mount = random_mount(random, random() % 2 == 0 ? MountFrame::level : MountFrame::body);
    if constexpr (std::is_same_v<P, Bearing>) {
      p.width = uniform(random, 0.02, 0.2), p.tilt = uniform(random, 0.05, 0.2);
    } else {
      p.kappa_G = uniform(random, 0.001, 0.1), p.kappa_A = uniform(random, 0.5, 20);
      p.form = random() % 2 == 0 ? ConeForm::sine : ConeForm::tangent;
    }
    return p;
  }
};
using Views = testing::Types<SensorCone, Bearing>;
TYPED_TEST_SUITE(ViewLaws, Views);

/// l, its gradient and its Hessian over all that a potential sees, as the solver has them.
struct Recorded {
  explicit Recorded(const Potential& potential) {
    Graph graph;
    const auto x = variables(graph, 0, pair_size);
    std::vector<Term> inputs;
    for (const Symbol& s : x) inputs.push_back(s.in(graph));
    const Term l =
        potential(sight_from<Symbol>(x.data()), sight_from<Symbol>(x.data() + sight_size), Symbol(0.0))
            .in(graph);
    const Derivatives d = derive(graph, l, inputs);
    std::vector<Term> outputs = {l};
    outputs.insert(outputs.end(), d.first.begin(), d.first.end());
    outputs.insert(outputs.end(), d.second.begin(), d.second.end());
    program = Program(graph, outputs, pair_size);
  }
  std::vector<double> at(std::span<const double> row) const { return evaluate(program, row); }
  static std::size_t gradient(int i) { return 1 + static_cast<std::size_t>(i); }
  static std::size_t hessian(int i, int j) {
    const int entry = 1 + pair_size + upper_index(i, j, pair_size);
    return static_cast<std::size_t>(entry);
  }

  Program program;
};

TYPED_TEST(PotentialLaws, TheValueIsTheSameOnEveryScalar) {
  const Recorded recorded{Potential(this->potential_)};
  const Potential erased(this->potential_);
  for (int k = 0; k < 1000; ++k) {
    const auto row = this->row(3);
    const double l = value<double>(this->potential_, row);
    EXPECT_TRUE(same_bits(value<Strict>(this->potential_, row).value(), l));
    EXPECT_TRUE(same_bits(value<NativeLane>(this->potential_, row)[native_width - 1], l));
    EXPECT_TRUE(same_bits(value<Tangent<double>>(this->potential_, row).value, l));
    EXPECT_TRUE(same_bits(
        erased(sight_from<double>(row.data()), sight_from<double>(row.data() + sight_size), 0.0), l));
    EXPECT_LE(relative_error(recorded.at(row)[0], l), 1e-12);
  }
}

TYPED_TEST(PotentialLaws, GradientAndHessianAreTheCentralDifferences) {
  const Recorded recorded{Potential(this->potential_)};
  const auto l = [&](const std::vector<Wide>& row) { return value<Wide>(this->potential_, row); };
  for (int k = 0; k < 60; ++k) {
    const auto row = this->row(1.5);
    const auto results = recorded.at(row);
    CentralDifference difference(l, row);
    for (int i = 0; i < pair_size; ++i) {
      const auto ui = static_cast<std::size_t>(i);
      ASSERT_LE(relative_error(results[Recorded::gradient(i)], difference.first(ui)), 1e-8) << k << ' ' << i;
      for (int j = i; j < pair_size; ++j) {
        const double second = difference.second(ui, static_cast<std::size_t>(j));
        ASSERT_LE(relative_error(results[Recorded::hessian(i, j)], second), 1e-6)
            << k << ' ' << i << ' ' << j;
      }
    }
  }
}

TYPED_TEST(PotentialLaws, ValueGradientAndHessianAreFiniteAKilometreAway) {
  const Recorded recorded{Potential(this->potential_)};
  for (int k = 0; k < 2000; ++k) {
    for (const double v : recorded.at(this->row(1e3))) ASSERT_TRUE(std::isfinite(v));
  }
}

TYPED_TEST(PotentialLaws, ValueGradientAndHessianAreFiniteWhereBothStandInOnePlace) {
  const Recorded recorded{Potential(this->potential_)};
  for (const double v : recorded.at(std::array<double, pair_size>{})) EXPECT_TRUE(std::isfinite(v));
}

TYPED_TEST(StepLaws, TheUnitStepWithoutSlopeIsZeroExactlyWhereTheLimitHolds) {
  TypeParam potential = this->potential_;
  potential.kappa_G = 0;
  double height = 1;
  if constexpr (requires { potential.kappa_H; }) height = potential.kappa_H;
  int met = 0;
  constexpr int poses = 20'000;
  for (int k = 0; k < poses; ++k) {
    const Sight<double> a = random_sight(this->random_, 2), b = random_sight(this->random_, 2);
    const double l = over(potential, UnitStep{}, a, b);
    if (Potential(potential).violation(a, b) <= 0) {
      ASSERT_EQ(l, 0.0);
      ++met;
    } else {
      // A box counts each side that is crossed.
      ASSERT_GE(l, height);
      ASSERT_EQ(l, height * std::round(l / height));
    }
  }
  EXPECT_GT(met, poses / 100);
  EXPECT_LT(met, poses * 99 / 100);
}

TYPED_TEST(StepLaws, TheSigmoidTendsToTheUnitStepAsKappaAGrows) {
  std::array<double, 6> mean{};  // distance from the unit step at kappa_A = 1, 10, ...
  for (int k = 0; k < 20'000; ++k) {
    const Sight<double> a = random_sight(this->random_, 2), b = random_sight(this->random_, 2);
    const double limit = over(this->potential_, UnitStep{}, a, b);
    for (std::size_t i = 0; i < mean.size(); ++i) {
      const SigmoidStep sig{std::pow(10.0, static_cast<double>(i))};
      mean[i] += std::fabs(over(this->potential_, sig, a, b) - limit) / 20'000;
    }
    ASSERT_LE(relative_error(over(this->potential_, SigmoidStep{1e12}, a, b), limit), 1e-12);  // (37)
  }
  for (std::size_t i = 1; i < mean.size(); ++i) EXPECT_LT(mean[i], 0.5 * mean[i - 1]);
}

TYPED_TEST(ViewLaws, OnlyTheTargetsPlaceCountsAndNoVelocity) {
  for (int k = 0; k < 1000; ++k) {
    const TypeParam view = this->any();
    Sight<double> a = random_sight(this->random_, 3), b = random_sight(this->random_, 3);
    const double l = view(a, b);
    a.v = random_point(this->random_, 3), b.v = random_point(this->random_, 3);
    b.d = random_pose(this->random_, 1).d;
    EXPECT_EQ(view(a, b), l);
  }
}

TYPED_TEST(ViewLaws, TheViolationIsTheViewAngleBeyondAlpha) {
  for (int k = 0; k < 1000; ++k) {
    const TypeParam view = this->any();
    const Sight<double> a = random_sight(this->random_, 3), b = random_sight(this->random_, 3);
    EXPECT_EQ(view.violation(a, b), view_angle(view.mount, a, b.p) - view.alpha);
  }
}

TYPED_TEST(PotentialLaws, BehindTheInterfaceItIsItself) {
  const Potential potential(this->potential_);
  EXPECT_EQ(potential.name(), TypeParam::name);
  EXPECT_EQ(potential.is_pair(), PairPotential<TypeParam>);
  ASSERT_NE(potential.as<TypeParam>(), nullptr);
  const auto a = random_sight(this->random_, 3), b = random_sight(this->random_, 3);
  if constexpr (!requires { &TypeParam::violation; }) {
    EXPECT_EQ(potential.violation(a, b), -infinite);
  } else if constexpr (PairPotential<TypeParam>) {
    EXPECT_EQ(potential.violation(a, b), this->potential_.violation(a, b));
    EXPECT_EQ((*potential.as<TypeParam>())(a, b), this->potential_(a, b));
  } else {
    EXPECT_EQ(potential.violation(a, b), this->potential_.violation(a));
    EXPECT_EQ(potential(a, b, 0.0), potential(a, a, 0.0));
  }
}

TYPED_TEST(StepLaws, BehindTheInterfaceItsStepAndItsSharpnessAreItsOwn) {
  const Potential potential(this->potential_), sharper = potential.sharpened(17.0);
  TypeParam other = this->potential_;
  other.kappa_A = 17.0;
  EXPECT_EQ(potential.kappa_A(), this->potential_.kappa_A);
  EXPECT_EQ(sharper.kappa_A(), 17.0);
  for (int k = 0; k < 100; ++k) {
    const auto a = random_sight(this->random_, 3), b = random_sight(this->random_, 3);
    EXPECT_EQ(potential.sloped(a, b), over(this->potential_, UnitStep{}, a, b));
    EXPECT_EQ(sharper(a, b, 0.0), Potential(other)(a, b, 0.0));
  }
}

/// A floor that rises by 1 m/s.
struct RisingFloor {
  static constexpr const char* name = "rising_floor";
  template <class S>
  S operator()(const Sight<S>& a, const S& t) const {
    return square(a.p.z - t);
  }
  double violation(const Sight<double>& a, double t) const { return t - a.p.z; }
};

TEST(Potential, OfOneRobotItsLimitMayDependOnTime) {
  const Potential floor(RisingFloor{});
  Sight<double> a;
  a.p = {0, 0, 2};
  EXPECT_FALSE(floor.is_pair());
  for (const double t : {0.0, 2.0, 5.0}) EXPECT_EQ(floor.violation(a, {}, t), t - 2.0);
}

TEST(Potential, WithASensorItsSensorCanBeMoved) {
  const SensorMount level = {0.0, 0.3};
  const Potential cone(SensorCone{.mount = {0.4, 0.1}}), moved = cone.seen_from(level);
  ASSERT_NE(cone.mount(), nullptr);
  EXPECT_EQ(cone.mount()->pitch, 0.4);
  EXPECT_EQ(moved.mount()->offset, 0.3);
  EXPECT_EQ(Potential(KeepOut{}).mount(), nullptr);
  EXPECT_NE(Potential(KeepOut{}).seen_from(level).as<KeepOut>(), nullptr) << "one without stays as it is";
}

TYPED_TEST(StepLaws, OneOutOfRangeNeverGetsBehindTheInterface) {
  TypeParam bad = this->potential_;
  bad.kappa_A = -1;
  const std::string sentence = refusal_of([&] { Potential p(bad); });
  EXPECT_NE(sentence.find(std::string(TypeParam::name) + ".kappa_A = -1, expected > 0"), std::string::npos);
}

/// Pulls two robots along a line that turns with time; without a name, a range or a limit.
struct Turning {
  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b, const S& time) const {
    return cos(time) * (a.p.x - b.p.x) + sin(time) * (a.p.y - b.p.y);
  }
};

/// Rises with the height and the time.
struct Tide {
  template <class S>
  S operator()(const Sight<S>& robot, const S& time) const {
    return time * robot.p.z;
  }
};

TEST(Potential, OneThatAsksForTheTimeGetsIt) {
  Random random(2);
  const Potential turning = Turning{}, tide = Tide{};
  EXPECT_TRUE(turning.is_pair());
  EXPECT_FALSE(tide.is_pair());
  Graph graph;
  const auto x = variables(graph, 0, pair_size + 1);
  const auto a = sight_from<Symbol>(x.data()), b = sight_from<Symbol>(x.data() + sight_size);
  const std::vector<Term> outputs = {turning(a, b, x[pair_size]).in(graph),
                                     tide(a, b, x[pair_size]).in(graph)};
  const Program program(graph, outputs, pair_size + 1);
  for (int k = 0; k < 100; ++k) {
    const auto row = uniform_array<pair_size + 1>(random, -3, 3);
    const auto p = sight_from<double>(row.data()), q = sight_from<double>(row.data() + sight_size);
    const double t = row[pair_size];
    EXPECT_EQ(turning(p, q, t), Turning{}(p, q, t));
    EXPECT_EQ(tide(p, q, t), t * p.p.z);
    const auto recorded = evaluate(program, row);
    EXPECT_LE(relative_error(recorded[0], turning(p, q, t)), 1e-14);
    EXPECT_LE(relative_error(recorded[1], tide(p, q, t)), 1e-14);
  }
}

TEST(Potential, OneThatIsNotWrittenOverAStepHasNone) {
  const Potential potential(Turning{});
  EXPECT_EQ(potential.name(), "potential");
  EXPECT_FALSE(potential.kappa_A());
  EXPECT_TRUE(std::isnan(potential.sloped({}, {})));
  EXPECT_NE(potential.sharpened(3.0).as<Turning>(), nullptr);
}

TEST(Require, RefusesWhatDoesNotHoldAndWhatIsNotFinite) {
  EXPECT_EQ(refusal_of([] { require(true, "p", "f", 1.5, "less"); }), "");
  EXPECT_EQ(refusal_of([] { require(false, "p", "f", 1.5, "less"); }), "p.f = 1.5, expected less");
  EXPECT_EQ(refusal_of([] { require(true, "p", "f", infinite, "less"); }), "p.f = inf, expected less");
  EXPECT_EQ(refusal_of([] { require(true, "p", "f", not_a_number, "less"); }), "p.f = nan, expected less");
}

/// Throws on numbers, not while it is recorded.
struct Moody {
  static constexpr std::string_view name = "moody";
  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    if constexpr (std::is_same_v<S, double>) throw std::runtime_error("not today");
    return dot(a.p - b.p, a.p - b.p);
  }
  double violation(const Sight<double>&, const Sight<double>&) const { throw 3; }
};

TEST(Potential, WhatThrowsIsNotANumber) {
  const Potential potential{Moody{}};
  EXPECT_TRUE(std::isnan(potential({}, {}, 0.0)));
  EXPECT_TRUE(std::isnan(potential.violation({}, {})));
}

}  // namespace
}  // namespace sightline
