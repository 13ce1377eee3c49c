#include <gtest/gtest.h>

#include <array>

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

}  // namespace
}  // namespace sightline
