#include "sightline/solver/newton/coupling.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sightline/formula.hpp"
#include "sightline/potentials.hpp"
#include "sightline/solver/newton/groups.hpp"
#include "tests/support/error.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

constexpr Horizon short_horizon{.T = 0.3, .N = 6, .dt = 0.01};

/// A team's potentials over random Sights, with what they need.
struct PotentialField {
  Ocp ocp;
  std::vector<BodyPotential> potentials;
  Groups groups;
  std::unique_ptr<Couplings> couplings;
  Rows s, c, z, y;

  /// @param is_compiled  as for trace_potentials
  PotentialField(Team team, Random& random, KernelChoice choice = KernelChoice::compiled_if_there,
                 const IsCompiled& is_compiled = {})
      : ocp(std::move(team), short_horizon),
        potentials(trace_potentials(ocp, is_compiled)),
        groups(ocp, potentials, choice),
        couplings(make_couplings(potentials, groups.layout(), ocp.team().bodies(), choice)),
        s(1, layout().s_length),
        c(1, layout().c_length),
        z(1, layout().s_length),
        y(1, layout().s_length) {
    for (int k = 0; k < layout().stages; ++k) {
      couplings->set_time(k, 0.1 * k);
      for (int b = 0; b < ocp.team().bodies(); ++b) {
        if (!ocp.team().is_agent(BodyId{b})) couplings->set_body(b, k, random_sight(random, 1.5));
      }
    }
    each_seen([&](std::ptrdiff_t at, int, int, int) { s[0][at] = uniform(random, -1.2, 1.2); });
  }

  const Layout& layout() const { return groups.layout(); }
  int agents() const { return static_cast<int>(layout().agents.size()); }

  /// f(place in s, agent, stage, entry) for all that can change; stage 0 is left to velocities.
  template <class F>
  void each_seen(F&& f) const {
    for (int a = 0; a < agents(); ++a) {
      for (int k = 1; k < layout().stages; ++k)
        for (int i = 0; i < layout().part(a).ns; ++i) f(layout().s(a)(k, i), a, k, i);
    }
  }

  /// What agent a costs: the potentials it feels.
  double cost_of(int a) {
    std::vector<double> values(potentials.size());
    couplings->values(s[0], values);
    double sum = 0.0;
    for (std::size_t p = 0; p < values.size(); ++p) {
      const BodyPotential& q = potentials[p];
      if ((q.a == a && q.ends.a_feels) || (q.b == a && q.ends.b_feels)) sum += values[p];
    }
    return sum;
  }
  double gradient(int a, int k, int i) const { return c[0][layout().c(a)(k, i)]; }
};

void expect_gradient_is_the_slope_of_costs(PotentialField& field) {
  field.couplings->evaluate(field.s[0], field.c[0]);
  field.each_seen([&](std::ptrdiff_t at, int a, int k, int i) {
    const double here = field.s[0][at], step = 1e-5;
    field.s[0][at] = here + step;
    const double above = field.cost_of(a);
    field.s[0][at] = here - step;
    const double below = field.cost_of(a);
    field.s[0][at] = here;
    EXPECT_NEAR(field.gradient(a, k, i), (above - below) / (2 * step), 1e-8);
  });
}

TEST(Couplings, TheGradientIsThatOfWhatTheAgentFeels) {
  Random random(1);
  for (int trial = 0; trial < 12; ++trial) {
    PotentialField field(random_team(random, 2 + static_cast<int>(random() % 4), Feeling::anyone), random);
    expect_gradient_is_the_slope_of_costs(field);
  }
}

/// The change of all gradients along z is what the own Hessians and the coupling blocks say.
void expect_product_is_the_derivative(PotentialField& field, Random& random) {
  field.each_seen([&](std::ptrdiff_t at, int, int, int) { field.z[0][at] = uniform(random, -1, 1); });
  const double step = 1e-5;
  std::vector<double> slope;
  Rows s_0(1, field.layout().s_length);
  std::copy_n(field.s[0], field.layout().s_length, s_0[0]);
  for (const double side : {1.0, -1.0}) {
    for (int i = 0; i < field.layout().s_length; ++i) field.s[0][i] = s_0[0][i] + side * step * field.z[0][i];
    field.couplings->evaluate(field.s[0], field.c[0]);
    std::size_t n = 0;
    field.each_seen([&](std::ptrdiff_t, int a, int k, int i) {
      if (side > 0) slope.push_back(0.0);
      slope[n++] += side * field.gradient(a, k, i) / (2 * step);
    });
  }
  std::copy_n(s_0[0], field.layout().s_length, field.s[0]);
  field.couplings->evaluate(field.s[0], field.c[0]);
  field.couplings->product(field.z[0], field.y[0]);
  std::size_t n = 0;
  field.each_seen([&](std::ptrdiff_t at, int a, int k, int i) {
    const int ns = field.layout().part(a).ns;
    double along = field.y[0][at];
    for (int j = 0; j < ns; ++j) {
      const int entry = ns + upper_index(std::min(i, j), std::max(i, j), ns);
      along += field.c[0][field.layout().c(a)(k, entry)] * field.z[0][field.layout().s(a)(k, j)];
    }
    EXPECT_NEAR(along, slope[n++], 1e-7);
  });
}

TEST(Couplings, HessiansAndProductAreTheDerivativeOfTheGradients) {
  Random random(2);
  for (int trial = 0; trial < 12; ++trial) {
    PotentialField field(random_team(random, 2 + static_cast<int>(random() % 4), Feeling::anyone), random);
    expect_product_is_the_derivative(field, random);
  }
}

Team plain_chain(int agents, bool masked) {
  Team team;
  std::vector<AgentId> ids;
  for (int i = 0; i < agents; ++i) ids.push_back(team.add(Multirotor{}));
  for (std::size_t i = 0; i + 1 < ids.size(); ++i) {
    const auto who = masked ? felt_by(ids[i]) : felt_by({ids[i], ids[i + 1]});
    team.couple(0.4 * SensorCone{}, {ids[i], ids[i + 1]}, who);
    team.couple(0.4 * Cohesion{}, {ids[i], ids[i + 1]}, who);
    team.couple(0.4 * KeepOut{}, {ids[i], ids[i + 1]}, who);
  }
  return team;
}

TEST(Couplings, TheTransposedProductIsTheAdjointOfTheProduct) {
  Random random(9);
  const auto expect_adjoint = [&](PotentialField& field) {
    const int n = field.layout().s_length;
    Rows w(1, n), y_transposed(1, n);
    field.each_seen([&](std::ptrdiff_t at, int, int, int) {
      field.z[0][at] = uniform(random, -1, 1), w[0][at] = uniform(random, -1, 1);
    });
    field.couplings->evaluate(field.s[0], field.c[0]);
    field.couplings->product(field.z[0], field.y[0]);
    for (int g = 0; g < static_cast<int>(field.layout().groups.size()); ++g)
      field.couplings->transposed_product(g, w[0], y_transposed[0]);
    double product = 0.0, adjoint = 0.0, size = 0.0;
    field.each_seen([&](std::ptrdiff_t at, int, int, int) {
      product += w[0][at] * field.y[0][at], adjoint += field.z[0][at] * y_transposed[0][at];
      size += std::fabs(w[0][at] * field.y[0][at]);
    });
    EXPECT_NEAR(product, adjoint, 1e-13 * (1.0 + size));
  };
  for (int trial = 0; trial < 12; ++trial) {
    PotentialField field(random_team(random, 2 + static_cast<int>(random() % 4), Feeling::anyone), random);
    expect_adjoint(field);
  }
  for (const int agents : {2, 3, 8, 19}) {
    PotentialField field(plain_chain(agents, true), random);
    expect_adjoint(field);
  }
}

TEST(Couplings, APotentialThatAPairHasTwiceCountsTwice) {
  Random random(5);
  for (const int robots : {2, 3, 9, 20}) {
    Team team;
    std::vector<AgentId> ids;
    for (int i = 0; i < robots; ++i) ids.push_back(team.add(Multirotor{}));
    for (std::size_t i = 0; i + 1 < ids.size(); ++i) {
      // The third keeps the others from being one formula.
      for (int twice = 0; twice < 2; ++twice) team.couple(0.4 * TooNear{}, {ids[i], ids[i + 1]}, {ids[i]});
      team.couple(0.1 * RelativeVelocity{}, {ids[i], ids[i + 1]}, {ids[i]});
    }
    PotentialField field(std::move(team), random, KernelChoice::compiled_if_there,
                         [](const Program& p) { return find_formula(p, native_width) != nullptr; });
    expect_gradient_is_the_slope_of_costs(field);
    expect_product_is_the_derivative(field, random);
  }
}

TEST(Couplings, LanesOfAgentsDoNotChangeTheLaws) {
  Random random(3);
  for (const int agents : {2, 3, 8, 19, 32}) {
    for (const bool masked : {false, true}) {
      PotentialField field(plain_chain(agents, masked), random);
      expect_product_is_the_derivative(field, random);
      Random same_1(4), same_2(4);
      PotentialField compiled(plain_chain(agents, masked), same_1),
          interpreted(plain_chain(agents, masked), same_2, KernelChoice::interpreted);
      for (PotentialField* f : {&compiled, &interpreted}) f->couplings->evaluate(f->s[0], f->c[0]);
      compiled.each_seen([&](std::ptrdiff_t, int a, int k, int i) {
        EXPECT_NEAR(compiled.gradient(a, k, i), interpreted.gradient(a, k, i), 1e-15);
      });
    }
  }
}

}  // namespace
}  // namespace sightline
