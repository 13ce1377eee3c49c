#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <tuple>

#include "sightline/formula.hpp"
#include "sightline/kernels.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

PosePotential trace(const std::vector<Weighted>& terms, const Ends& ends = {},
                    Numbers numbers = Numbers::known) {
  std::vector<const Weighted*> pointers;
  for (const Weighted& t : terms) pointers.push_back(&t);
  return trace_potential(pointers, default_horizon.h(), ends, numbers);
}

TEST(PosePotential, WhatDependsOnTheRelativePositionIsFoundSo) {
  EXPECT_TRUE(trace({0.4 * SensorCone{}}).relative);
  EXPECT_TRUE(trace({0.4 * KeepOut{}, 0.3 * Cohesion{}, 0.2 * SensorCone{}}).relative);
  EXPECT_FALSE(trace({1.0 * ChangingPace{}}).relative);
  EXPECT_FALSE(trace({0.4 * KeepOut{}}, {.a_is_agent = true, .b_is_agent = false}).relative);
  EXPECT_FALSE(trace({0.4 * AltitudeBand{}}, {true, false, true, false}).relative);
}

TEST(PosePotential, ValueIsTheWeightedSumTimesH) {
  Random random(1);
  const std::vector<Weighted> terms = {0.4 * SensorCone{}, 0.3 * KeepOut{}};
  const PosePotential p = trace(terms);
  for (int trial = 0; trial < 100; ++trial) {
    const Sight<double> a = random_sight(random, 2.0), b = random_sight(random, 2.0);
    const Vec3<double> r = a.p - b.p;
    double l = 0.0;
    for (const Weighted& t : terms) l += t.weight * t.potential(a, b, 0.0);
    EXPECT_NEAR(evaluate(p.value, std::array{r.x, r.y, r.z, a.d.x, a.d.y})[0], default_horizon.h() * l,
                1e-14 * (1 + l));
  }
}

TEST(PosePotential, WithParametersItGivesTheSameNumbers) {
  Random random(2);
  for (const std::vector<Weighted>& terms :
       {std::vector{0.4 * SensorCone{}, 0.3 * KeepOut{}}, {1.0 * Cohesion{.kappa_G = 0.0, .kappa_A = 1.0}}}) {
    const PosePotential known = trace(terms), general = trace(terms, {}, Numbers::parameters);
    EXPECT_TRUE(general.relative);
    EXPECT_EQ(known.variables, general.variables);
    for (int trial = 0; trial < 100; ++trial) {
      const std::vector<double> z = random_numbers(random, 5, 2.0);
      const auto a = evaluate(known.derivatives, z), b = evaluate(general.derivatives, z);
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-13 * (1 + std::fabs(a[i])));
    }
  }
}

TEST(PosePotential, TermsFallIntoThoseThatWereCompiledAndARest) {
  Team team;
  const AgentId a = team.add(Multirotor{}), b = team.add(Multirotor{});
  const std::vector<Weighted> terms = {0.4 * SensorCone{}, 0.3 * KeepOut{}, 0.2 * Cohesion{}};
  for (const Weighted& t : terms) team.couple(t, {a, b});
  const Ocp ocp(team, {.T = 1.0, .N = 20, .dt = 0.01});
  const Program compiled = trace({terms[2], terms[0]}, {}, Numbers::parameters).derivatives;
  const auto list = trace_potentials(ocp, [&](const Program& p) { return p == compiled; });
  ASSERT_EQ(list.size(), 1u);
  const PosePotential &p = list[0].potential, whole = trace(terms);
  EXPECT_EQ(p.derivatives, compiled);
  ASSERT_EQ(p.others.size(), 1u);
  EXPECT_EQ(p.value, whole.value);
  Random random(3);
  const std::vector<double> z = random_numbers(random, 5, 2.0);
  const auto first = evaluate(p.derivatives, z), other = evaluate(p.others[0], z),
             expected = evaluate(whole.derivatives, z);
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(first[i] + other[i], expected[i], 1e-13 * (1 + std::fabs(expected[i])));
}

TEST(PosePotential, AnEndThatFeelsNothingHasNoRow) {
  const PosePotential p = trace({1.0 * ChangingPace{}}, {.a_feels = true, .b_feels = false});
  for (const auto& g : p.gradient) EXPECT_LT(g.variable, sight_size);
  for (const auto& s : p.own) EXPECT_LT(s.row, sight_size);
  EXPECT_FALSE(p.cross.empty()) << "a still sees b move";
}

/// A potential with two parameters that multiply the same number.
struct Twins {
  double a = 0.7, b = 0.7;
  static constexpr std::string_view name = "twins";
  static constexpr auto parameters() {
    return std::tuple{parameter("a", &Twins::a, "1/m", any_finite, "frequency"),
                      parameter("b", &Twins::b, "1/m", any_finite, "growth")};
  }

  template <class S>
  S operator()(const Sight<S>& one, const Sight<S>& other) const {
    const S x = one.p.x - other.p.x;
    return sin(a * x) + exp(b * x);
  }
};

TEST(PosePotential, SlopesAreThoseOfTheFormulaAlsoIfParametersAreEqual) {
  Random random(4);
  for (const double b : {0.7, 0.4}) {
    const Weighted term = 0.5 * Twins{.a = 0.7, .b = b};
    const double h = default_horizon.h(), a = 0.7;
    const PotentialSlopes slopes = trace_slopes(std::array{&term}, h, {}, false);
    ASSERT_TRUE(slopes.relative);
    ASSERT_EQ(slopes.along, slopes.variables);
    for (int trial = 0; trial < 20; ++trial) {
      const double x = uniform(random, -2, 2), dx = uniform(random, -1, 1);
      const auto out = evaluate(slopes.program, std::array{x, 0.3, 0.1, 1.0, 0.0, dx, 0.2, 0.4, 0.0, 0.1});
      ASSERT_EQ(out.size(), 3u);
      EXPECT_NEAR(out[0], h * dx * (a * std::cos(a * x) + b * std::exp(b * x)), 1e-12);
      EXPECT_NEAR(out[1], h * 0.5 * dx * (std::cos(a * x) - a * x * std::sin(a * x)), 1e-11);
      EXPECT_NEAR(out[2], h * 0.5 * dx * (1 + b * x) * std::exp(b * x), 1e-11);
    }
  }
}

}  // namespace
}  // namespace sightline
