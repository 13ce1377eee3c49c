#include <gtest/gtest.h>

#include <cmath>

#include "sightline/formula.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// l, its gradient and its Hessian over both Sights, as the solver has them.
Program record(const Potential& potential) {
  Graph graph;
  const auto z = variables(graph, 0, 2 * sight_size);
  std::vector<Term> inputs;
  for (const Symbol& s : z) inputs.push_back(s.in(graph));
  const Term l =
      potential(sight_from<Symbol>(z.data()), sight_from<Symbol>(z.data() + sight_size), 0.0).in(graph);
  const Derivatives d = derive(graph, l, inputs);
  std::vector<Term> outputs = {l};
  outputs.insert(outputs.end(), d.first.begin(), d.first.end());
  outputs.insert(outputs.end(), d.second.begin(), d.second.end());
  return Program(graph, outputs, 2 * sight_size);
}

std::array<double, 2 * sight_size> draw(Random& random, double reach) {
  std::array<double, 2 * sight_size> z;
  write_sight(random_sight(random, reach), z);
  write_sight(random_sight(random, reach), std::span(z).last(sight_size));
  return z;
}

struct Twins {
  Region text;
  Potential built_in;
};

std::vector<Twins> twins() {
  const Region cone =
      Region(
          all_of({Limits("x > 0", "x^2 + y^2 + z^2"), Limits("y^2 + z^2 < (x * sin(alpha))^2", "y^2 + z^2")}),
          {{"alpha", "0.5 rad"}})
          .slope(Quadratic{.kappa_G = 0.01})
          .sigmoid(2);
  const Region keep_out = Region("distance^2 > d_min^2", {{"d_min", "1 m"}})
                              .slope(Quadratic{.kappa_G = 0.001, .grows_with = "-distance^2", .kappa_H = 4.5})
                              .sigmoid(3);
  const Region cohesion = Region("distance^2 < d_max^2", {{"d_max", "2 m"}})
                              .slope(Quadratic{.kappa_G = 0.001, .grows_with = "distance^2", .kappa_H = 1.5})
                              .sigmoid(3);
  return {{cone.seen_from({0.5, 0.17}), SensorCone{}}, {keep_out, KeepOut{}}, {cohesion, Cohesion{}}};
}

TEST(Region, ThePaperSPotentialsAsTextHaveTheBuiltInValueGradientAndHessian) {
  for (const auto& [text, built_in] : twins()) {
    const Program ours = record(text), theirs = record(built_in);
    Random random(1);
    for (const double reach : {1.0, 3.0, 30.0}) {
      for (int k = 0; k < 300; ++k) {
        const auto z = draw(random, reach);
        const auto a = evaluate(ours, z), b = evaluate(theirs, z);
        for (std::size_t i = 0; i < a.size(); ++i) {
          ASSERT_LE(relative_error(a[i], b[i]), 1e-12) << built_in.name() << " output " << i;
        }
      }
    }
  }
}

TEST(Region, TheUnitStepsOfThePaperSPotentialsAreTheBuiltInOnes) {
  Random random(2);
  const auto t = twins();
  const auto* cone = t[0].built_in.as<SensorCone>();
  for (int k = 0; k < 20'000; ++k) {
    const Sight<double> a = random_sight(random, 2), b = random_sight(random, 2);
    ASSERT_LE(
        relative_error(t[0].text.sloped(a, b, 0), cone->over(UnitStep{}, Pose<double>(a), Pose<double>(b))),
        1e-12);
    for (std::size_t i = 1; i < 3; ++i) {
      ASSERT_EQ(t[i].text.unit_step(a, b, 0), t[i].built_in.violation(a, b) > 0 ? 1.0 : 0.0);
    }
  }
}

TEST(Region, TheUnitStepIsZeroExactlyWhereTheLogicOfTheLimitsHolds) {
  const Limits one = "x > 0 m", two = "distance < 2 m", three = "z > 0.1 m";
  struct Case {
    Limits limits;
    bool (*holds)(bool, bool, bool);
  };
  const std::vector<Case> cases = {
      {all_of({one, two, three}), [](bool a, bool b, bool c) { return a && b && c; }},
      {any_of({one, two, three}), [](bool a, bool b, bool c) { return a || b || c; }},
      {!one, [](bool a, bool, bool) { return !a; }},
      {!all_of({one, !two}), [](bool a, bool b, bool) { return !(a && !b); }},
      {any_of({all_of({one, two}), !any_of({two, three})}),
       [](bool a, bool b, bool c) { return (a && b) || !(b || c); }},
  };
  Random random(3);
  for (const Case& each : cases) {
    const Region region(each.limits), steep = region.sigmoid(1e9);
    int inside = 0;
    for (int k = 0; k < 3000; ++k) {
      const Sight<double> a = random_sight(random, 2), b = random_sight(random, 2);
      const auto met = [&](const Limits& limit) { return Region(limit).violation(a, b, 0) <= 0; };
      const double l = each.holds(met(one), met(two), met(three)) ? 0.0 : 1.0;
      ASSERT_EQ(region.unit_step(a, b, 0), l);
      ASSERT_EQ(region.sloped(a, b, 0), l);
      ASSERT_NEAR(steep(a, b, 0), l, 1e-9);  // (37)
      inside += l == 0.0;
    }
    EXPECT_GT(inside, 100);
    EXPECT_LT(inside, 2900);
  }
}

TEST(Region, ASoftplusSlopePullsBackFromAnywhereWhereASigmoidAloneDoesNot) {
  const Region far = Region("distance < 2 m").sigmoid(5), slope = far.slope(Softplus{.kappa_G = 0.7});
  const auto pull = [](const Region& region, double D) {
    Sight<double> a, b;
    a.d = b.d = {1, 0};
    b.p = {D, 0, 0};
    const double l = region(a, b, 0);
    b.p.x = D + 1e-3;
    return (region(a, b, 0) - l) / 1e-3;
  };
  for (const double D : {3.0, 10.0, 100.0, 1000.0}) {
    EXPECT_NEAR(pull(slope, D), 0.7, 0.05) << D;
    if (D >= 10) {
      EXPECT_EQ(pull(far, D), 0.0) << D;
    }
  }
}

TEST(Region, TheSoftplusOfAnyOfIsTheShorterWayBack) {
  const Region region =
      Region(any_of({"r_x < 1 m", "r_y < 1 m"})).slope(Softplus{.kappa_G = 1, .kappa_H = 0});
  Sight<double> a, b;
  b.p = {4, 11, 0};
  EXPECT_NEAR(region.sloped(a, b, 0), 3.0, 1e-9);
  EXPECT_NEAR(region.sigmoid(50)(a, b, 0), 3.0, 1e-3);
}

TEST(Region, EveryQuantityIsWhatItsNameSays) {
  Random random(4);
  SensorMount mount{0.4, 0.1};
  const auto value = [&](const std::string& text, const Sight<double>& a, const Sight<double>& b, double t) {
    return Region(text + " < 0").seen_from(mount).violation(a, b, t);
  };
  for (int k = 0; k < 200; ++k) {
    Sight<double> a = random_sight(random, 3);
    const Sight<double> b = random_sight(random, 3);
    a.third = random_sight(random, 3).p;
    mount.frame = k % 2 == 0 ? MountFrame::level : MountFrame::body;
    const Vec3<double> p_S = mount(a, b.p);
    const double t = uniform(random, 0, 9);
    EXPECT_EQ(value("x", a, b, t), p_S.x);
    EXPECT_EQ(value("z", a, b, t), p_S.z);
    EXPECT_NEAR(value("range", a, b, t), norm(p_S), 1e-14);
    EXPECT_NEAR(value("bearing", a, b, t), view_angle(mount, a, b.p), 1e-14);
    EXPECT_NEAR(value("azimuth", a, b, t), std::atan2(p_S.y, p_S.x), 1e-14);
    EXPECT_NEAR(value("elevation", a, b, t), std::atan2(p_S.z, std::hypot(p_S.x, p_S.y)), 1e-14);
    EXPECT_NEAR(value("distance", a, b, t), norm(a.p - b.p), 1e-14);
    EXPECT_EQ(value("r_y", a, b, t), b.p.y - a.p.y);
    EXPECT_EQ(value("observer.p_z", a, b, t), a.p.z);
    EXPECT_EQ(value("observer.d_y", a, b, t), a.d.y);
    EXPECT_EQ(value("target.v_x", a, b, t), b.v.x);
    EXPECT_EQ(value("target.v_z", a, b, t), b.v.z);
    EXPECT_EQ(value("observer.lean_f", a, b, t), a.lean.x);
    EXPECT_EQ(value("target.lean_s", a, b, t), b.lean.y);
    EXPECT_EQ(value("t", a, b, t), t);
    EXPECT_EQ(value("third.p_x", a, b, t), a.third.x);
    EXPECT_EQ(value("third.p_z", a, b, t), a.third.z);
  }
}

TEST(Region, IsAViewIfItLooksThroughTheSensor) {
  EXPECT_TRUE(Region("x > 0").is_view());
  EXPECT_TRUE(Region(all_of({"distance < 3 m", "bearing < 1"})).is_view());
  EXPECT_FALSE(Region("distance < 3 m").is_view());
  EXPECT_FALSE(Region("target.p_z > observer.p_z").is_view());
}

TEST(Region, LooksPastAThirdBodyIfAnyOfItsFormulasDoes) {
  EXPECT_FALSE(Region("distance > 1 m").sees_third());
  EXPECT_TRUE(Region(all_of({"distance > 1 m", "third.p_z < r_z"})).sees_third());
  EXPECT_TRUE(Region("high > 1 m", {{"high", "third.p_z"}}).sees_third());
  const Region grows = Region("distance > 1 m").slope(Quadratic{0.1, "third.p_y^2"});
  EXPECT_TRUE(grows.sees_third());
  EXPECT_FALSE(grows.slope(NoSlope{}).sees_third());
}

TEST(Region, WhatIsSmoothedIsToldAndByWhichWidth) {
  EXPECT_TRUE(Region("distance^2 < 4 m^2").smoothed().empty()) << "the square undoes the root";
  EXPECT_EQ(Region("abs(y) < x").smoothed(), std::set<std::string>{"abs"});
  EXPECT_EQ(Region("x > 0").slope(Quadratic{.grows_with = "range"}).smoothed(),
            std::set<std::string>{"norm"});
  const Region corner = Region("abs(r_y) < 1 m").slope(Softplus{.kappa_H = 0}).sigmoid(1e3);
  Sight<double> a, b;
  b.p.y = 3;
  for (const double width : {1e-3, 1e-1}) {
    const double l = corner.smoothed_over(width)(a, b, 0);
    EXPECT_NEAR(l, std::sqrt(9 + width * width) - 1, 1e-9);
  }
}

TEST(Region, ParametersMayBeFormulasAndHaveRanges) {
  Sight<double> a, b;
  b.p.x = 3;
  const auto excess = [&](const std::vector<Parameter>& p) {
    return Region("distance < far", p).violation(a, b, 0);
  };
  EXPECT_DOUBLE_EQ(excess({{"far", 2.5}}), 0.5);
  EXPECT_DOUBLE_EQ(excess({{"far", "2 * near"}, {"near", "120 cm"}}), 0.6);
  EXPECT_DOUBLE_EQ(excess({{"far", "2 m", "1 m", "2 m"}}), 1.0);
  const auto refusal = [&](const std::vector<Parameter>& p) { return refusal_of([&] { excess(p); }); };
  EXPECT_EQ(refusal({{"far", "2 m", "3 m", "4 m"}}), "1:1: it is 2 in SI units, expected 3 m to 4 m");
  EXPECT_NE(refusal({{"far", "2 m", "1 s", "4 s"}}).find("expected m as the value is"), std::string::npos);
  EXPECT_NE(refusal({{"range", 1.0}}).find("expected a name of its own"), std::string::npos);
  EXPECT_NE(refusal({{"far", 1.0}, {"far", 2.0}}).find("expected a name of its own"), std::string::npos);
  EXPECT_NE(refusal({{"far", "1 s"}}).find("joins m with s"), std::string::npos);
}

TEST(Region, TooMuchOfItIsRefused) {
  Limits deep = "x > 0";
  for (int i = 0; i < 100; ++i) deep = all_of({deep});
  EXPECT_NE(refusal_of([&] { Region region(deep); }).find("nested deeper than 16"), std::string::npos);
  EXPECT_NE(refusal_of([] { Region region(all_of(std::vector<Limits>(65, "x > 0"))); }).find("64 limits"),
            std::string::npos);
  EXPECT_NE(refusal_of([] { Region region(all_of({})); }).find("expected limits"), std::string::npos);
}

TEST(Region, ParametersOutOfRangeAreRefusedByName) {
  const Region region = Region("x > 0").named("mine");
  const auto refusal = [](const Region& r) { return refusal_of([&] { Potential potential(r); }); };
  EXPECT_EQ(refusal(region.sigmoid(-1)), "mine.kappa_A = -1, expected > 0");
  EXPECT_EQ(refusal(region.smoothed_over(0)), "mine.smooth = 0, expected > 0");
  EXPECT_EQ(refusal(region.slope(Softplus{.kappa_G = 0})), "mine.slope.kappa_G = 0, expected > 0");
  EXPECT_EQ(refusal(region.slope(Quadratic{.kappa_H = 0})), "mine.slope.kappa_H = 0, expected > 0");
  EXPECT_EQ(Potential(region).name(), "mine");
}

}  // namespace
}  // namespace sightline
