/// The default solver: one exact Newton step per update on the coupled optimality conditions, with
/// a Riccati factorisation per robot and Krylov iterations for the couplings.
///
/// Single shooting: the trajectory is rolled out from the measured state, so the dynamics hold
/// exactly and the unknowns are the inputs. Each update warm-starts from the previous plan,
/// extrapolated in time. Limits are exact, by an active set that is relinearised when it changes.
/// An unreliable step is damped, shortened or, at worst, rejected. docs/equations.md, 11.
#pragma once

#include <memory>

#include "sightline/solver/team_planner.hpp"

namespace sightline {

class ThreadPool;
enum class KernelChoice;

struct NewtonRiccatiOptions {
  int max_newton_steps = 1;   ///< per update, >= 1; the first update after a start may take `start_steps`
  double tolerance = 1e-6;    ///< status is `converged` up to this residual [1/s], > 0
  int max_krylov = 4;         ///< Krylov iterations, or substitution passes, per step, >= 0
  double krylov_stop = 1e-3;  ///< stop when the correction is this small in the norm of the Hessian, >= 0
  double step_cap =
      0.5;  ///< a larger step of an input in its scale, or a larger residual, triggers a line search, > 0
  double deadline = 0.0;   ///< an update ends then [s], after the step in progress, at least one; 0: none
  int start_steps = 10;    ///< Newton steps of the first update at most, >= 1
  KernelChoice kernels{};  ///< compiled if available; kernels/kernel_table.hpp
  /// Thread pool for teams of at least `shared_from` robots; null: the calling thread alone. The
  /// result is the same.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 128;
};

namespace newton {
struct Workspace;
}

class NewtonRiccati final : public Solver, public TeamPlanner {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit NewtonRiccati(Ocp ocp, const NewtonRiccatiOptions& options = {});
  NewtonRiccati(const Team& team, const Horizon& horizon, const NewtonRiccatiOptions& options = {})
      : NewtonRiccati(Ocp(team, horizon), options) {}
  NewtonRiccati(NewtonRiccati&& other) noexcept;
  NewtonRiccati& operator=(NewtonRiccati&& other) noexcept;
  ~NewtonRiccati() override;

  std::string_view name() const override { return "newton_riccati"; }
  const Ocp& ocp() const override;
  Solution solve(double time, std::span<const double> states) noexcept override;
  void set_applied(const AppliedInputs& applied) noexcept override;
  void set_view_uncertainty(std::span<const ViewUncertainty> of_bodies) noexcept override;
  bool uses_uncertainty() const noexcept override { return true; }
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  TeamPlanner* team_planner() noexcept override { return this; }
  bool keeps_apart() const noexcept override { return true; }
  KernelUse kernels() const override;

  void plan(int k, std::span<double> u) const noexcept override;
  void set_plan(int k, std::span<const double> u) noexcept override;
  void set_prediction(const Prediction& prediction) noexcept override;
  double tolerance() const noexcept override;

 private:
  std::unique_ptr<newton::Workspace> workspace_;
};

}  // namespace sightline
