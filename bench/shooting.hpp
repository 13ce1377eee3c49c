/// An Ocp as a large sparse program for an interior-point method, by multiple shooting.
///
/// The unknowns are the inputs u_k and the states x_{k+1} of all stages. The constraints are
/// x_k + h f(x_k, u_k) - x_{k+1} = 0. Derivatives are exact, from the formulas of the Ocp, and
/// share no code with the solvers.
#pragma once

#include <span>
#include <vector>

#include "sightline/formula.hpp"
#include "sightline/potentials.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// The problem of some agents; the trajectories of all others are fixed.
class MultipleShooting {
 public:
  /// An entry of a sparse matrix, and the source of its value.
  struct Nonzero {
    int row, column;
    const double* value;    ///< of a formula at a stage, times h; null: `constant`
    double constant = 0.0;  ///< the value itself
  };

  explicit MultipleShooting(Ocp ocp);
  MultipleShooting(const MultipleShooting&) = delete;
  MultipleShooting& operator=(const MultipleShooting&) = delete;

  const Ocp& ocp() const { return ocp_; }
  /// Sets the states x of all bodies (nx) at time t [s], and the inputs (N x nu) that define the
  /// trajectories.
  void set(double t, std::span<const double> x, std::span<const double> inputs);
  /// Selects the agents (indices) whose trajectories are unknown.
  void choose(const std::vector<int>& agents);

  int unknowns() const { return N() * per_stage_; }
  int constraints() const { return N() * constraints_per_stage_; }
  /// Nonzeros of the constraints' Jacobian; entries at one place add up.
  const std::vector<Nonzero>& jacobian() const { return jacobian_; }
  /// Nonzeros of the Lagrangian's Hessian, lower triangle; entries at one place add up.
  const std::vector<Nonzero>& hessian() const { return hessian_; }

  /// The unknowns at the present point.
  std::vector<double> point() const;
  void move_to(const double* w);
  void bounds(std::vector<double>& low, std::vector<double>& high) const;

  // The following functions evaluate at the present point.
  double cost() const;  ///< part of sum h l + phi in the costs of the unknown agents
  void gradient(double* dJ);
  void defects(double* d) const;
  void jacobian_values(double* values);
  /// Hessian of sigma cost + lambda' defects.
  void hessian_values(double sigma, const double* lambda, double* values);

  /// Inputs of all agents (N x nu).
  std::vector<double> inputs() const;

 private:
  /// The programs of a formula and their results, over the stages.
  struct Bound {
    Evaluation first, second;
    Rows first_out, second_out;
  };

  int N() const { return ocp_.horizon().N; }
  double h() const { return ocp_.horizon().h(); }
  int x_at(BodyId body) const { return ocp_.team().state_offset(body); }
  int u_at(BodyId body) const { return ocp_.team().input_offset(body); }
  double time(int k) const { return t_ + k * h(); }

  void bind();
  int variable(BodyId body, int i, int k) const;
  std::vector<double> next(BodyId body, int k) const;
  void roll_out(BodyId body);
  double stage(int k) const;

  Ocp ocp_;
  double t_ = 0.0;
  Rows x_, u_, reference_, lambda_, time_, weights_;  // one row per variable, over the stages
  std::vector<Bound> agents_, pairs_;
  std::vector<HeadingErrorLimit> heading_limits_;  // of each agent

  std::vector<int> free_;       // agents
  std::vector<int> variables_;  // of each body: its index in a stage's unknowns, or -1
  std::vector<int> rows_;       // of each body: its index in a stage's constraints
  int per_stage_ = 0, constraints_per_stage_ = 0;
  std::vector<Nonzero> jacobian_, hessian_;
};

}  // namespace sightline
