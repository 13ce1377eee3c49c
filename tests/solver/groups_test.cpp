#include "sightline/solver/newton/groups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "sightline/robots.hpp"
#include "tests/support/felt_team.hpp"

namespace sightline {
namespace {

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
