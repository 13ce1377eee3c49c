#include "sightline/potential/tracking.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <vector>

#include "sightline/formula.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/strict.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

constexpr std::size_t nx = 7, nu = 4;

struct Problem {
  explicit Problem(Random& random)
      : x(uniform_array<nx>(random, -3, 3)),
        x_ref(uniform_array<nx>(random, -3, 3)),
        Q(uniform_array<nx>(random, 0, 2)),
        u(uniform_array<nu>(random, -1, 1)),
        u_ref(uniform_array<nu>(random, -1, 1)),
        R(uniform_array<nu>(random, 0.1, 2)) {}

  template <class S>
  S cost() const {
    const auto as = [](const auto& a) { return std::vector<S>(a.begin(), a.end()); };
    const auto sx = as(x), sx_ref = as(x_ref), sQ = as(Q), su = as(u), su_ref = as(u_ref), sR = as(R);
    return tracking_cost<S>(sx, sx_ref, sQ, su, su_ref, sR);
  }

  std::array<double, nx> x, x_ref, Q;
  std::array<double, nu> u, u_ref, R;
};

TEST(Tracking, IsTheWeightedSumOfSquares) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const Problem p(random);
    double expected = 0;
    for (std::size_t i = 0; i < nx; ++i) expected += p.Q[i] * (p.x[i] - p.x_ref[i]) * (p.x[i] - p.x_ref[i]);
    for (std::size_t i = 0; i < nu; ++i) expected += p.R[i] * (p.u[i] - p.u_ref[i]) * (p.u[i] - p.u_ref[i]);
    EXPECT_LE(relative_error(p.cost<double>(), expected), 1e-14);
    EXPECT_EQ(p.cost<Strict>().value(), p.cost<double>());
    EXPECT_EQ(p.cost<NativeLane>()[0], p.cost<double>());
  }
}

TEST(Tracking, TheHessianIsTwiceTheWeightsAndConstant) {
  Random random(3);
  const Problem p(random);
  Graph graph;
  const auto x = variables(graph, 0, nx);
  std::vector<Term> inputs;
  for (const Symbol& s : x) inputs.push_back(s.in(graph));
  const std::vector<Symbol> x_ref(p.x_ref.begin(), p.x_ref.end()), Q(p.Q.begin(), p.Q.end());
  const Symbol cost = tracking_cost<Symbol>(x, x_ref, Q, {}, {}, {});
  const Derivatives d = derive(graph, cost.in(graph), inputs);
  for (int i = 0; i < static_cast<int>(nx); ++i) {
    for (int j = i; j < static_cast<int>(nx); ++j) {
      const Term entry = d.second[static_cast<std::size_t>(upper_index(i, j, nx))];
      ASSERT_TRUE(graph.is_constant(entry));
      EXPECT_EQ(graph.constant_value(entry), i == j ? 2 * p.Q[static_cast<std::size_t>(i)] : 0.0);
    }
  }
}

TEST(Tracking, OppositeToTheWantedHeadingIsStationaryAndTheDearest) {
  const std::vector<double> Q = {0.7, 0.7}, wanted = {1.0, 0.0};
  const auto at = [&](double psi) {
    const std::vector<double> d = {std::cos(psi), std::sin(psi)};
    return tracking_cost<double>(d, wanted, Q, {}, {}, {});  // (25)
  };
  EXPECT_NEAR(at(pi), 4 * 0.7, 1e-15);
  for (const double off : {1e-3, 0.1, 1.0, 3.0}) {
    EXPECT_LT(at(pi - off), at(pi));
    EXPECT_NEAR(at(pi - off), at(pi + off), 1e-14);
  }
  EXPECT_NEAR((at(pi + 1e-4) - at(pi - 1e-4)) / 2e-4, 0.0, 1e-11);
}

}  // namespace
}  // namespace sightline
