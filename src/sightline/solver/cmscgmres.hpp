/// The paper's solver: condensed multiple shooting continuation/GMRES (Shimizu, Ohtsuka, Diehl 2009),
/// section 3.
///
/// It follows the root of the optimality conditions over time, dF/dt = -zeta F, dG/dt = -zeta G, (5), instead
/// of solving them; docs/equations.md, 7 has the update in full. Limits enter through a multiplier and a
/// slack per input.
#pragma once

#include <vector>

#include "sightline/solver/gmres.hpp"
#include "sightline/solver/hamiltonian.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

/// How the product of the Jacobian with a vector is formed.
enum class JacobianProduct {
  exact,               ///< the tangent of the sweeps, docs/equations.md, 8
  forward_difference,  ///< of the sweeps themselves, as the paper does
};

struct CmscgmresOptions {
  double zeta = 10.0;             ///< decay of the residual [1/s], > 0; stable for zeta dt < 2, smooth to 1
  int k_max = 30;                 ///< GMRES iterations an update, >= 1
  double alpha = 2.0;             ///< growth of the horizon, T (1 - e^(-alpha t)) [1/s], > 0
  double difference_step = 1e-8;  ///< eps of the differences in time [s], > 0
  double slack_weight = 0.01;     ///< k of -k s in H, > 0: how soon a limit is felt
  JacobianProduct jacobian = JacobianProduct::exact;
  double gmres_tolerance = 1e-8;  ///< GMRES stops at this ||b - A U'||, >= 0
  double tolerance = 1e-3;        ///< status is `converged` up to this residual, > 0
};

class Cmscgmres final : public Solver {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit Cmscgmres(Ocp ocp, const CmscgmresOptions& options = {});
  Cmscgmres(const Team& team, const Horizon& horizon, const CmscgmresOptions& options = {})
      : Cmscgmres(Ocp(team, horizon), options) {}

  std::string_view name() const override { return "cmscgmres"; }
  const Ocp& ocp() const override { return ocp_; }
  Solution solve(double time, std::span<const double> states) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void restart() noexcept override { started_ = false; }

 private:
  /// Unknowns of one stage: u, mu, s, each of all agents (nu).
  int stride() const { return 3 * nu_; }
  double stage_length(double t) const noexcept;

  bool accept(std::span<const double> states) noexcept;
  void start(double time) noexcept;
  /// Defects of X and Lambda, N+1 x nx each.
  struct Defects {
    std::vector<double> x, lambda;
  };
  void residuals(Hamiltonian& hamiltonian, const std::vector<double>& x, double* F, Defects& G) noexcept;
  void sweep(const double* U, const Defects& G, double scale) noexcept;
  void limit_rows(const Hamiltonian& at, const double* U, double* F) const noexcept;
  void product(const double* v, double* out) noexcept;
  void difference_product(const double* v, double* out) noexcept;
  [[nodiscard]] bool advance(double step) noexcept;
  [[nodiscard]] bool limits_hold_their_sign() const noexcept;
  void clamp_inputs(std::span<const double> u) noexcept;
  void keep_plan(double time) noexcept;
  Solution fall_back(double time, Status status) noexcept;

  Ocp ocp_;
  CmscgmresOptions options_;
  int N_, nx_, nu_, unknowns_;
  Hamiltonian here_;   // at the measured state
  Hamiltonian there_;  // a difference step later
  Gmres gmres_;

  bool started_ = false;
  double started_at_ = 0.0, last_time_ = 0.0;
  std::vector<double> x_, x_soon_, rate_;  // measured state, normalised; predicted; its rate
  Rows vectors_;                           // of all unknowns: see the names below
  double *U_, *U_dot_, *F_, *F_there_, *b_, *U_trial_, *F_soon_;
  std::vector<double> X_, Lambda_, X_trial_, Lambda_trial_;  // N+1 x nx
  Defects G_, G_soon_;
  std::vector<double> H_z_, u_, raw_u_;

  std::vector<double> plan_;  // inputs of the last good update, N x nu
  double plan_time_ = 0.0, plan_h_ = 0.0;
};

}  // namespace sightline
