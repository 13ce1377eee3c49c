/// The optimal control problem of a team over a horizon, the input of every solver. Constant and
/// shareable.
///
///   min over u   phi(x(t_f), t_f) + int l(x, u, tau) dtau                        (1)
///   subject to   x' = f(x, u),  x(t_0) = x_k,  u_min <= u <= u_max               (2)
///   with         l = sum_i l_i(x_i, u_i) + sum_c k_c l_c(x_i, x_j)               (8)
///
/// Discrete: h = T/N, x_{i+1} = x_i + h f(x_i, u_i). The first request traces the formulas of each
/// agent and each coupled pair, once for all copies. Agents and pairs of one kind share a program.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/formula/program.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

struct Horizon {
  double T = 1.0;    ///< length [s], > 0
  int N = 20;        ///< stages, 1..1000
  double dt = 0.01;  ///< control period [s], >= 1e-4

  double h() const { return T / N; }
};

/// A structural nonzero of a matrix that changes along the horizon: its place, and the output that holds it.
struct Entry {
  int row, column, output;
};

/// One agent's stage, z = (x, u):
///
///   inputs    x (nx), u (nu), x* (nx), u* (nu), Q (nx), R (nu), t, lambda (nx, `second` alone)
///   first     l_z (nx + nu), then the nonzeros of f_z
///   second    the nonzeros of the Hessian of l + lambda' f with respect to z
///
/// where l holds the tracking cost, the agent's constraints and its barriers.
struct AgentFormula {
  std::shared_ptr<const Program> first, second;
  std::vector<Entry> jacobian;  ///< of f: row in x, column in z, output of `first`
  std::vector<Entry> hessian;   ///< row and column in z, both triangles, output of `second`
};

/// The couplings between one pair of bodies that are alike, at their full weights, z = (x_a, u_a,
/// x_b, u_b):
///
///   inputs    z, t, then x and u of the third body, if there is one
///   first     l_z for each variable in `gradient`
///   second    the nonzeros of the Hessian with respect to the agents' part of z
///
/// Rows of agents outside `felt_by` are missing, so the mask acts on H_u and H_x alike, (9), (10).
struct PairFormula {
  BodyId a, b, third;
  std::shared_ptr<const Program> first, second;
  std::vector<Entry> gradient;  ///< row in z; column unused (0), output of `first`
  std::vector<Entry> hessian;   ///< row and column in z, output of `second`
};

/// All formulas of a problem.
struct Formulas {
  std::vector<AgentFormula> agents;  ///< in the order of team().agents()
  std::vector<PairFormula> pairs;
};

class Ocp {
 public:
  /// @throws std::invalid_argument for a horizon out of range or a team without agents
  Ocp(Team team, const Horizon& horizon);

  const Team& team() const { return team_; }
  const Horizon& horizon() const { return horizon_; }
  int nx() const { return team_.nx(); }
  int nu() const { return team_.nu(); }

  /// The first call on any copy traces them, which takes milliseconds and allocates: a solver
  /// requests them in its constructor. Thread-safe; concurrent callers wait. The formulas live as
  /// long as a copy.
  /// @throws what a formula throws while it is traced; the next call tries again
  const Formulas& formulas() const;
  /// Whether they are traced.
  bool is_traced() const noexcept;

  /// Body of each agent, in the order of team().agents().
  const std::vector<BodyId>& agent_bodies() const { return agent_bodies_; }

 private:
  struct Traced;  // shared by all copies

  Team team_;
  Horizon horizon_;
  std::vector<BodyId> agent_bodies_;
  std::shared_ptr<Traced> traced_;
};

/// l(x, u, t) of the whole team with the weights at t, regardless of the mask, at the stacked
/// states and inputs.
/// @throws std::invalid_argument unless x has nx and u has nu numbers
double stage_cost(const Team& team, double t, std::span<const double> x, std::span<const double> u);

}  // namespace sightline
