#include <gtest/gtest.h>

#include "sightline/kernels.hpp"
#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/solver.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/default_horizon.hpp"

namespace sightline {
namespace {

std::vector<std::string> interpreted(const KernelUse& use) {
  std::vector<std::string> names;
  for (const KernelUse::Formula& f : use.formulas) {
    if (!f.compiled) names.push_back(f.name);
  }
  return names;
}

/// Two multirotors and a rover; the first looks at the second.
struct Watched {
  Team team;
  AgentId a = team.add(Multirotor{}), b = team.add(Multirotor{}), c = team.add(OmniRover{});
  Watched() { team.couple(0.4 * Bearing{}, {a, b}); }
};

TEST(KernelUse, RobotsAndPotentialsOfTheLibraryAreCompiled) {
  const Watched watched;
  const KernelUse use = NewtonRiccati(watched.team, default_horizon).kernels();
  EXPECT_EQ(use.formulas.size(), 3u);
  EXPECT_EQ(interpreted(use), std::vector<std::string>{});
  EXPECT_EQ(use.sentence(), "");
}

TEST(KernelUse, WhatWasNotPrintedIsNamed) {
  Watched watched;
  const AgentId odd = watched.team.add(Multirotor{.a_f = 0.0});
  watched.team.couple(0.4 * Bearing{}, {odd, watched.a});
  watched.team.couple(0.4 * Region("range < 6 m"), {odd, watched.a});
  watched.team.couple(1.0 * Region("range < 6 m"), {watched.a, watched.c});
  const KernelUse use = NewtonRiccati(watched.team, default_horizon).kernels();
  EXPECT_EQ(interpreted(use), (std::vector<std::string>{"robot multirotor", "region"}));
  EXPECT_EQ(use.sentence(),
            "2 of 4 formulas are interpreted, several times slower than compiled: robot "
            "multirotor, region");
}

TEST(KernelUse, ASolverToldToInterpretSaysSo) {
  const Watched watched;
  const KernelUse use =
      NewtonRiccati(watched.team, default_horizon, {.kernels = KernelChoice::interpreted}).kernels();
  EXPECT_EQ(interpreted(use).size(), use.formulas.size());
}

TEST(KernelUse, ASolverThatLooksForNoneHasNothingToSay) {
  const Watched watched;
  EXPECT_EQ(Cmscgmres(Ocp(watched.team, default_horizon), {}).kernels().sentence(), "");
}

}  // namespace
}  // namespace sightline
