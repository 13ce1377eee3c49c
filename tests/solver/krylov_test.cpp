#include "sightline/solver/newton/krylov.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/support/default_horizon.hpp"
#include "tests/support/felt_team.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

using test::team_with;

/// || ds + P^-1 C ds - ds_0 ||: zero for the step of the whole team.
double defect(const Team& team, Random& random) {
  const Ocp ocp(team, default_horizon);
  const std::vector<BodyPotential> potentials = trace_potentials(ocp);
  const int agents = static_cast<int>(ocp.agent_bodies().size());
  Groups groups(ocp, potentials, KernelChoice::compiled_if_there);
  const Layout& layout = groups.layout();
  const auto couplings = make_couplings(potentials, layout, team.bodies(), KernelChoice::compiled_if_there);
  Rows u(6, layout.u_length), s(5, layout.s_length), c(1, layout.c_length);
  for (int a = 0; a < agents; ++a) {
    const Pose<double> pose = random_pose(random, 1.5);
    const auto x = Multirotor{}.at_rest(pose);
    for (int i = 0; i < 7; ++i)
      groups.group_of(a).x(0, i, layout.place(a).lane) = x[static_cast<std::size_t>(i)];
  }
  groups.roll_out(u[0], s[0]);
  couplings->evaluate(s[0], c[0]);
  groups.solve(u[0], u[1], c[0], u[2], u[3], s[1]);
  Krylov krylov(layout, influence_graph(potentials, agents), *couplings, 1, 60, 1e-13);
  std::copy_n(s[1], layout.s_length, s[2]);
  ThreadPool alone(1);
  const Krylov::Completion step = krylov.complete(groups, *couplings, u[3], s[2], alone);
  if (step.along != nullptr) {
    for (int i = 0; i < layout.u_length; ++i) u[3][i] += step.by * step.along[i];
  }
  // The inputs found are what counts: their Sights follow from the linearised dynamics, by
  // differences.
  const double by = 1e-6;
  Rows moved(2, layout.s_length);
  for (const int side : {0, 1}) {
    for (int i = 0; i < layout.u_length; ++i) u[4][i] = u[0][i] + (side == 0 ? by : -by) * u[3][i];
    groups.roll_out(u[4], moved[side]);
  }
  for (int i = 0; i < layout.s_length; ++i) s[2][i] = (moved[0][i] - moved[1][i]) / (2 * by);
  groups.roll_out(u[0], s[0]);
  couplings->product(s[2], s[3]);
  groups.precondition(s[3], u[5], s[4]);
  double worst = 0.0;
  for (int i = 0; i < layout.s_length; ++i) worst = std::max(worst, std::fabs(s[2][i] + s[4][i] - s[1][i]));
  return worst;
}

TEST(Krylov, StepsThatAreAlikeAreCompletedInFewerIterationsToTheSame) {
  Random random(3);
  std::vector<std::array<int, 3>> chain;
  for (int i = 1; i < 40; ++i) chain.push_back({i, i - 1, i});
  const Team team = team_with(40, chain);
  const Ocp ocp(team, default_horizon);
  const std::vector<BodyPotential> potentials = trace_potentials(ocp);
  const InfluenceGraph graph = influence_graph(potentials, 40);
  Groups groups(ocp, potentials, KernelChoice::compiled_if_there, graph.order);
  const Layout& layout = groups.layout();
  const auto couplings = make_couplings(potentials, layout, team.bodies(), KernelChoice::compiled_if_there);
  Rows u(5, layout.u_length), s(2, layout.s_length), c(1, layout.c_length);
  for (int a = 0; a < 40; ++a) {
    const auto x = Multirotor{}.at_rest(random_pose(random, 1.5));
    for (int i = 0; i < 7; ++i)
      groups.group_of(a).x(0, i, layout.place(a).lane) = x[static_cast<std::size_t>(i)];
  }
  groups.roll_out(u[0], s[0]);
  couplings->evaluate(s[0], c[0]);
  Krylov krylov(layout, graph, *couplings, 1, 60, 1e-6);
  ThreadPool alone(1);
  std::array<int, 3> iterations{};
  for (int& n : iterations) {
    groups.solve(u[0], u[1], c[0], u[2], u[3], s[1]);
    n = krylov.complete(groups, *couplings, u[3], s[1], alone, WarmStart::of_updates).iterations;
    if (&n == iterations.data()) std::copy_n(u[3], layout.u_length, u[4]);
  }
  EXPECT_GT(iterations[0], 1);
  EXPECT_EQ(iterations[1], iterations[0]);  // whether steps are alike is not known yet
  EXPECT_LT(iterations[2], iterations[0]);
  for (int i = 0; i < layout.u_length; ++i) EXPECT_NEAR(u[3][i], u[4][i], 1e-5) << i;
}

TEST(Krylov, EveryKindOfTeamGetsTheStepOfTheWhole) {
  Random random(1);
  for (int trial = 0; trial < 5; ++trial) {
    EXPECT_LE(defect(team_with(4, {{0, 1, -1}, {1, 2, -1}, {2, 3, -1}, {0, 2, -1}}), random), 1e-7);
    EXPECT_LE(defect(team_with(4, {{0, 1, 0}, {1, 2, 1}, {2, 3, 2}, {0, 2, 0}}), random), 1e-7);
    EXPECT_LE(defect(team_with(3, {{0, 1, 0}, {1, 2, 1}, {2, 0, 2}}), random), 1e-7);
    EXPECT_LE(defect(team_with(4, {{0, 1, 0}, {1, 2, -1}, {2, 3, 3}}), random), 1e-7);
  }
}

TEST(Krylov, ALongCascadeInAnyOrderAndLongCyclesGetTheStepOfTheWhole) {
  Random random(2);
  for (int trial = 0; trial < 3; ++trial) {
    const int n = 20;
    std::vector<int> at(static_cast<std::size_t>(n));
    std::iota(at.begin(), at.end(), 0);
    std::shuffle(at.begin(), at.end(), random);
    std::vector<std::array<int, 3>> chain, apart;
    for (int i = 1; i < n; ++i) {
      const int one = at[static_cast<std::size_t>(i)], before = at[static_cast<std::size_t>(i - 1)];
      chain.push_back({one, before, one});
      if (i > 1) apart.push_back({one, at[static_cast<std::size_t>(i - 2)], -1});
    }
    EXPECT_LE(defect(team_with(n, chain), random), 1e-7);
    apart.insert(apart.end(), chain.begin(), chain.end());
    EXPECT_LE(defect(team_with(n, apart), random), 1e-7);
  }
}

}  // namespace
}  // namespace sightline
