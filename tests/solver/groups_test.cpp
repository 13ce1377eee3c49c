#include "sightline/solver/newton/groups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "tests/support/felt_team.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

TEST(Groups, EveryAgentHasALaneAndEqualModelsShareGroups) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Ocp ocp(random_team(random, 1 + static_cast<int>(random() % 9), Feeling::anyone), {.N = 5});
    const auto potentials = trace_potentials(ocp);
    const Groups groups(ocp, potentials, KernelChoice::interpreted);
    std::set<std::pair<int, int>> places;
    for (std::size_t a = 0; a < ocp.agent_bodies().size(); ++a) {
      const Layout::Place& place = groups.layout().place(static_cast<int>(a));
      EXPECT_TRUE(places.emplace(place.group, place.lane).second);
      EXPECT_LT(place.lane, groups.layout().width);
      EXPECT_EQ(groups.group_of(static_cast<int>(a)).sizes().nx, ocp.team().agents()[a].model.nx());
    }
  }
}

TEST(Groups, TheNarrowestPacksThatHoldAllOfAKindAtOnceAreTaken) {
  for (const auto& [multirotors, rovers, width] : {std::tuple{1, 0, 2},
                                                   {2, 2, 2},
                                                   {3, 0, narrow_width},
                                                   {4, 1, narrow_width},
                                                   {1, 3, narrow_width},
                                                   {5, 2, native_width},
                                                   {20, 0, native_width}}) {
    Team team;
    for (int i = 0; i < multirotors; ++i) team.add(Multirotor{});
    for (int i = 0; i < rovers; ++i) team.add(OmniRover{});
    EXPECT_EQ(Groups(Ocp(team, {.N = 5}), {}, KernelChoice::compiled_if_there).layout().width, width)
        << multirotors << " and " << rovers;
  }
}

TEST(Groups, NeighboursOfAChainStandInNeighbouringGroupsAtOneLane) {
  Team team;
  for (int i = 0; i < 3 * native_width; ++i) team.add(Multirotor{});
  const Ocp ocp(team, {.N = 5});
  const Groups groups(ocp, {}, KernelChoice::compiled_if_there);
  EXPECT_EQ(groups.layout().groups.size(), native_width > 1 ? 3u : groups.layout().groups.size());
  for (int a = 0; a + 1 < 3 * native_width; ++a) {
    const Layout::Place &here = groups.layout().place(a), &next = groups.layout().place(a + 1);
    if (here.group + 1 == next.group) {
      EXPECT_EQ(here.lane, next.lane);
    }
  }
}

TEST(Groups, AnAgentsTrackingCostIsItsOwnSum) {
  Team team;
  team.add(Multirotor{}, {.Q = {1, 2, 3, 0, 0, 0.5, 0.5}, .u_ref = {0.1, 0, 0, 0}});
  team.add(Multirotor{}, {.name = "other"});
  const Ocp ocp(team, {.T = 0.5, .N = 10});
  Groups groups(ocp, {}, KernelChoice::compiled_if_there);
  Rows u(1, groups.layout().u_length), s(1, groups.layout().s_length);
  groups.roll_out(u[0], s[0]);
  Rows own(1, groups.layout().width);
  groups.own_costs(0, u[0], own[0]);
  EXPECT_NEAR(own[0][0], 0.5 * 0.01, 1e-15);
  EXPECT_EQ(own[0][1], 0.0);
}

TEST(Groups, DampingThatGoesOnLeadsToTheStepOfOneThatBeginsAtNone) {
  const Ocp ocp(test::team_with(2, {{0, 1, -1}}), {.T = 0.5, .N = 10});
  Groups groups(ocp, trace_potentials(ocp), KernelChoice::compiled_if_there);
  const Layout& layout = groups.layout();
  Rows u(4, layout.u_length), s(2, layout.s_length), c(2, layout.c_length);
  for (const int a : {0, 1}) groups.group_of(a).x(0, 3, layout.place(a).lane) = 1.0;  // d = (1, 0)
  groups.roll_out(u[0], s[0]);
  const auto steps = [&](const double* curvature, double* du, Damping begins) {
    return groups.solve(0, u[0], u[1], curvature, u[2], du, s[1], begins);
  };
  // The first robot's potential bends down along p_x.
  const Layout::View first = layout.c(0);
  const int ns = layout.part(0).ns;
  for (int k = 0; k < layout.stages; ++k) c[1][first(k, 0)] = 1.0, c[1][first(k, ns)] = -1e3;
  EXPECT_FALSE(steps(c[0], u[3], Damping::none));
  EXPECT_TRUE(steps(c[1], u[3], Damping::none));
  Rows again(1, layout.u_length);
  EXPECT_TRUE(steps(c[1], again[0], Damping::last));
  for (int i = 0; i < layout.u_length; ++i) EXPECT_EQ(again[0][i], u[3][i]) << i;
  EXPECT_LT(*std::min_element(u[3], u[3] + layout.u_length), 0.0);
  EXPECT_TRUE(steps(c[0], again[0], Damping::last));
  EXPECT_FALSE(steps(c[0], again[0], Damping::none));
}

}  // namespace
}  // namespace sightline
