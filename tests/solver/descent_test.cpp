#include "sightline/solver/newton/descent.hpp"

#include <gtest/gtest.h>

#include "tests/support/default_horizon.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(Descent, WhatItsUnitsPayDoesNotRiseAndLimitsHold) {
  Random random(1);
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    const Ocp ocp(paper::team(variant), default_horizon);
    const auto potentials = trace_potentials(ocp);
    Groups groups(ocp, potentials, KernelChoice::compiled_if_there);
    const Layout& layout = groups.layout();
    const auto couplings = make_couplings(potentials, layout, 2, KernelChoice::compiled_if_there);
    Descent descent(potentials, layout, influence_graph(potentials, 2));
    ThreadPool pool(1);
    Rows u(5, layout.u_length), s(1, layout.s_length);
    std::fill_n(u[2], layout.u_length, -1.0);
    std::fill_n(u[3], layout.u_length, 1.0);
    std::vector<double> value(potentials.size());
    Rows own(static_cast<int>(layout.groups.size()), layout.width);
    const auto cost = [&](const double* inputs) {
      groups.roll_out(inputs, s[0]);
      couplings->values(s[0], value);
      const auto own_of = [&](int a) {
        const Layout::Place& place = layout.place(a);
        groups.own_costs(place.group, inputs, own[place.group]);
        return own[place.group][place.lane];
      };
      return std::array{own_of(0) + value[0], own_of(1)};
    };
    for (int trial = 0; trial < 50; ++trial) {
      for (int a = 0; a < 2; ++a) {
        const auto x = Multirotor{}.at_rest(random_pose(random, 2.0));
        for (int i = 0; i < 7; ++i)
          groups.group_of(a).x(0, i, layout.place(a).lane) = x[static_cast<std::size_t>(i)];
      }
      for (int i = 0; i < layout.u_length; ++i) {
        u[0][i] = uniform(random, -1, 1);
        u[1][i] = uniform(random, -2, 2);
      }
      const auto before = cost(u[0]);
      const auto expect_no_rise = [&] {
        const auto after = cost(u[4]);
        if (variant == paper::Variant::joint) {
          EXPECT_LE(after[0] + after[1], before[0] + before[1]);
        } else {
          EXPECT_LE(after[1], before[1]) << "uav1 pays for itself alone";
        }
      };
      const double alpha = descent.search(groups, *couplings, u[0], u[1], u[2], u[3], u[4], s[0], pool);
      EXPECT_GE(alpha, 0.0);
      expect_no_rise();
      for (int i = 0; i < layout.u_length; ++i) EXPECT_TRUE(u[4][i] >= -1 && u[4][i] <= 1);

      const double late = descent.search(groups, *couplings, u[0], u[1], u[2], u[3], u[4], s[0], pool,
                                         Searching::all, {.holds = true});
      EXPECT_TRUE(late == 0.0 || late == 1.0) << "one length is tried";
      EXPECT_EQ(late == 1.0, alpha >= 1.0);
      expect_no_rise();
    }
  }
}

}  // namespace
}  // namespace sightline
