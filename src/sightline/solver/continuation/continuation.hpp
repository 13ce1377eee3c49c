/// Base class of the continuation/GMRES solvers: they track the root of the optimality conditions
/// over time, dF/dt = -zeta F, (5), instead of solving F = 0 anew. Full update: docs/equations.md,
/// 7.
///
/// Limits enter through one multiplier and one slack per input (7.4). The horizon grows from zero
/// length, so that the start is a root. The derived class defines the states between the stages:
/// unknowns with defects (`Cmscgmres`), or rolled out from the measured state (`Cgmres`).
#pragma once

#include <vector>

#include "sightline/solver/continuation/gmres.hpp"
#include "sightline/solver/continuation/hamiltonian.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

/// How the product of the Jacobian with a vector is computed.
enum class JacobianProduct {
  exact,               ///< tangent of the sweeps, docs/equations.md, 8
  forward_difference,  ///< forward difference of the sweeps, as in the paper
};

struct ContinuationOptions {
  double zeta = 10.0;  ///< decay rate of the residual [1/s], > 0; stable for zeta dt < 2, smooth to 1
  int k_max = 30;      ///< GMRES iterations per update, >= 1
  double alpha = 2.0;  ///< growth rate of the horizon, T (1 - e^(-alpha t)) [1/s], > 0
  double difference_step = 1e-8;  ///< eps of the finite differences in time [s], > 0
  double slack_weight = 0.01;     ///< k of -k s in H, > 0: how early a limit acts
  JacobianProduct jacobian = JacobianProduct::exact;
  double gmres_tolerance = 1e-8;  ///< GMRES stops at this ||b - A U'||, >= 0
  double tolerance = 1e-3;        ///< status is `converged` up to this residual, > 0
};

class Continuation : public Solver {
 public:
  const Ocp& ocp() const override { return ocp_; }
  Solution solve(double time, std::span<const double> states) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  /// Uses `offset` in the limits and `u_ref` in the costs; ignores the rest.
  void set_applied(const AppliedInputs& applied) noexcept override;

  /// Numbers that the solver keeps from update to update.
  virtual int unknowns() const { return unknowns_; }

 protected:
  /// @throws std::invalid_argument naming an option out of its range
  Continuation(Ocp ocp, const ContinuationOptions& options);

  /// Defects of X and Lambda, N+1 x nx each; empty if the trajectory has no defects.
  struct Defects {
    std::vector<double> x, lambda;
  };
  static std::size_t at(int i, int n) { return static_cast<std::size_t>(i) * static_cast<std::size_t>(n); }
  /// Unknowns of one stage: u, mu, s, each of all agents (nu).
  int stride() const { return 3 * nu_; }

  /// F and G at (U, x, t), with the Hamiltonian's t; linearises the Hamiltonian there and sets X_0
  /// = x.
  virtual void residuals(Hamiltonian& hamiltonian, const std::vector<double>& x, double* F,
                         Defects& G) noexcept = 0;
  /// U += step U', by `move_unknowns`; the trajectories follow; X_0 becomes the measured state.
  virtual void advance(double step) noexcept = 0;

  void move_unknowns(double step) noexcept;
  /// X, Lambda and F with the defects `scale` G at (U, x_soon, t + eps).
  void sweep(const double* U, const Defects& G, double scale) noexcept;
  /// Adds mu C_u to the rows of u; writes the rows of mu and s, C = ((u - m)/r)^2 / 2 - 1/2 + s^2.
  void limit_rows(const Hamiltonian& hamiltonian, const double* U, double* F) const noexcept;

  Ocp ocp_;
  ContinuationOptions options_;
  int N_, nx_, nu_, unknowns_;
  Hamiltonian here_;                       // at the measured state
  Hamiltonian there_;                      // one difference step later
  std::vector<double> x_, x_soon_, rate_;  // measured state, normalised; predicted; its rate

 private:
  Gmres gmres_;
  Rows vectors_;  // vectors of all unknowns: U_ to F_soon_ below

 protected:
  double *U_, *U_dot_, *F_, *F_there_, *b_, *U_trial_, *F_soon_;
  std::vector<double> X_, Lambda_, X_trial_, Lambda_trial_;  // N+1 x nx
  Defects G_, G_soon_;
  std::vector<double> H_z_;

 private:
  double stage_length(double t) const noexcept;
  bool accept(std::span<const double> states) noexcept;
  void start(double time) noexcept;
  void product(const double* v, double* out) noexcept;
  void difference_product(const double* v, double* out) noexcept;
  [[nodiscard]] bool limits_hold() const noexcept;
  void clamp_inputs(std::span<const double> u) noexcept;
  void keep_plan(double time) noexcept;
  Solution fall_back(double time, Status status) noexcept;

  bool started_ = false;
  double started_at_ = 0.0, last_time_ = 0.0;
  std::vector<double> u_, raw_u_, x_out_;
  std::vector<double> scales_;  // of the inputs (nu)

  std::vector<double> plan_;  // inputs of the last good update, N x nu
  double plan_time_ = 0.0, plan_h_ = 0.0;
};

}  // namespace sightline
