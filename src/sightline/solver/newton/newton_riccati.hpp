/// The default solver: one exact Newton step an update on the coupled optimality conditions, a Riccati
/// factorisation for each robot, Krylov iterations for the couplings.
///
/// Single shooting: the trajectory is rolled out from the measured state, so the dynamics hold exactly and
/// the unknowns are the inputs. Limits are exact, by an active set that is relinearised when it changes.
/// Where a step cannot be trusted it is damped, shortened or, at worst, not taken. docs/equations.md, 11.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "sightline/solver/newton/descent.hpp"
#include "sightline/solver/newton/prediction.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

struct NewtonRiccatiOptions {
  int max_newton_steps = 1;  ///< an update, >= 1; the first after a start may take `start_steps`
  double tolerance = 1e-6;   ///< status is `converged` up to this residual [1/s], > 0
  int max_krylov = 4;        ///< Krylov iterations or sweeps a step, >= 0
  double krylov_stop =
      1e-3;  ///< they stop once the correction is this small in the norm of the Hessian, >= 0
  double step_cap =
      0.5;  ///< beyond this step of an input in its scale, or this residual, costs are watched until steps fit, > 0
  double deadline = 0.0;  ///< an update ends about this time [s] after it began, and a first step; 0: none
  int start_steps = 10;   ///< Newton steps of the first update at most, >= 1
  KernelChoice kernels = KernelChoice::compiled_if_there;
};

class NewtonRiccati final : public Solver {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit NewtonRiccati(Ocp ocp, const NewtonRiccatiOptions& options = {});
  NewtonRiccati(const Team& team, const Horizon& horizon, const NewtonRiccatiOptions& options = {})
      : NewtonRiccati(Ocp(team, horizon), options) {}

  std::string_view name() const override { return "newton_riccati"; }
  const Ocp& ocp() const override { return ocp_; }
  Solution solve(double time, std::span<const double> states) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  KernelUse kernels() const override;

  /// The inputs planned at stage k, of all agents (nu): what the next update starts from. Here and below a stage or a
  /// length that is not the problem's changes nothing.
  void plan(int k, std::span<double> u) const noexcept;
  /// Puts another plan in its place, limits permitting; for a team that changed. All stages must be set.
  void set_plan(int k, std::span<const double> u) noexcept;
  /// Goes on from the plan of another team's solver: agents that both have, by name, get their inputs of it, the
  /// others keep what is planned for them here. Neither allocates nor blocks. From a horizon of other stages, nothing.
  void take_over(const NewtonRiccati& before) noexcept;

  /// Sets the predicted trajectory of a body that is not controlled here, at most N + 1 sights; without it the body is
  /// taken to keep its velocity. It is used for updates within one horizon of its time, until the next one is set; an
  /// empty one ends it. One that is too long, or of a robot that is planned here, is ignored.
  void set_prediction(const Prediction& told) noexcept;

 private:
  using Clock = std::chrono::steady_clock;

  /// What one step came to.
  struct Step {
    double residual = std::numeric_limits<double>::infinity();
    int iterations = 0;
    bool finite = true, in_time = true;
    bool whole = false;  ///< neither damped nor shortened, and its active set is settled
  };
  /// What one pass over a proposed step finds.
  struct Proposal {
    double largest = 0.0;   ///< |du|, in the scale of each input
    double residual = 0.0;  ///< of u, where finite
    bool finite = true;     ///< du and H_u are
    bool within_limits = true;
  };

  bool accept(std::span<const double> states) noexcept;
  void set_time(double time) noexcept;
  void start() noexcept;
  Step newton_step() noexcept;
  Proposal examine() const noexcept;
  bool slope_is_finite() const noexcept;
  bool update_held() noexcept;
  void take() noexcept;
  bool descend(bool settled) noexcept;
  bool late() const noexcept;
  bool is_stage(int k, std::span<const double> u) const noexcept;
  void write_inputs() noexcept;
  void write_states() noexcept;
  Solution fall_back(double time, Status status) noexcept;

  Ocp ocp_;
  NewtonRiccatiOptions options_;
  std::vector<BodyPotential> potentials_;
  std::vector<SwarmPotential> swarms_;
  Groups groups_;
  InfluenceGraph influence_;
  std::unique_ptr<Couplings> couplings_;
  Krylov krylov_;
  Descent descent_;

  bool started_ = false, has_plan_ = false;
  bool all_free_ = true;  // no input is held at a limit
  bool limits_move_ = false;
  bool wary_ = false;  // steps are watched until one could be taken whole, or the optimum is near
  double time_ = 0.0;
  Clock::time_point begin_{};
  Rows u_vectors_, s_vectors_, c_;
  double *u_, *du_, *held_, *H_u_, *low_, *high_, *u_before_, *plan_, *u_start_;
  double *per_scale_, *scale_2_;  // of each input, for what is compared with a threshold
  double *s_, *ds_;
  double plan_time_ = 0.0;
  std::vector<int> x_at_;                // of each agent in the stacked state
  std::vector<Prediction> predictions_;  // of each body; room for N + 1 sights of those not controlled
  std::vector<double> x_now_, limits_, u_out_, raw_u_, x_out_;
};

}  // namespace sightline
