/// An Ocp as the large sparse program that an interior-point method likes: multiple shooting.
///
/// Unknown are the inputs u_k and the states x_{k+1} of all stages; x_k + h f(x_k, u_k) - x_{k+1} = 0 are the
/// constraints. Derivatives are exact, from the formulas of the Ocp, and share no code with the solvers.
#pragma once

#include <span>
#include <vector>

#include "sightline/formula/interpret.hpp"
#include "sightline/ocp/ocp.hpp"
#include "sightline/potential/heading_error_limit.hpp"

namespace sightline {

/// The problem of some agents, with the trajectories of all others held.
class MultipleShooting {
 public:
  /// A place in a sparse matrix, and where its value comes from.
  struct Nonzero {
    int row, column;
    const double* value;    ///< of a formula at a stage, times h; null: `constant`
    double constant = 0.0;  ///< as it stands
  };

  explicit MultipleShooting(Ocp ocp);
  MultipleShooting(const MultipleShooting&) = delete;
  MultipleShooting& operator=(const MultipleShooting&) = delete;

  const Ocp& ocp() const { return ocp_; }
  /// States x of all bodies (nx) at time t [s], and inputs (N x nu) that give the trajectories.
  void set(double t, std::span<const double> x, std::span<const double> inputs);
  /// Which agents (indices) are unknown.
  void choose(const std::vector<int>& agents);

  int unknowns() const { return N() * per_stage_; }
  int constraints() const { return N() * constraints_per_stage_; }
  /// Nonzeros of the constraints' Jacobian; several at one place add up.
  const std::vector<Nonzero>& jacobian() const { return jacobian_; }
  /// The same of the Lagrangian's Hessian, lower triangle.
  const std::vector<Nonzero>& hessian() const { return hessian_; }

  /// The point: its unknowns.
  std::vector<double> point() const;
  void move_to(const double* w);
  void bounds(std::vector<double>& low, std::vector<double>& high) const;

  // All at the point.
  double cost() const;  ///< what the unknown agents feel of sum h l + phi
  void gradient(double* dJ);
  void defects(double* d) const;
  void jacobian_values(double* values);
  /// Of sigma cost + lambda' defects.
  void hessian_values(double sigma, const double* lambda, double* values);

  /// Inputs of all agents (N x nu).
  std::vector<double> inputs() const;

 private:
  /// A formula's programs and their results, over stages.
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
  Rows x_, u_, reference_, lambda_, time_, weights_;  // a row is one variable over the stages
  std::vector<Bound> agents_, pairs_;
  std::vector<HeadingErrorLimit> heading_limits_;  // of each agent

  std::vector<int> free_;       // agents
  std::vector<int> variables_;  // of each body, its place in a stage's unknowns, or -1
  std::vector<int> rows_;       // of each body, its place in a stage's constraints
  int per_stage_ = 0, constraints_per_stage_ = 0;
  std::vector<Nonzero> jacobian_, hessian_;
};

}  // namespace sightline
