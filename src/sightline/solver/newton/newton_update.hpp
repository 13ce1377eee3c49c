/// The iterate of NewtonRiccati and all it works with: one update is an exact Newton step on it. Functions are those of
/// Solver and TeamPlanner.
#pragma once

#include <algorithm>
#include <chrono>
#include <memory>
#include <vector>

#include "sightline/base/no_value.hpp"
#include "sightline/potential/heading_error_limit.hpp"
#include "sightline/solver/newton/descent.hpp"
#include "sightline/solver/newton/newton_riccati.hpp"
#include "sightline/solver/newton/phase_schedule.hpp"

namespace sightline {

class NewtonUpdate final : public PredictedStates::Writer {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  NewtonUpdate(Ocp ocp, const NewtonRiccatiOptions& options);

  /// As Solver::kernels().
  KernelUse kernels() const;
  const Ocp& ocp() const { return ocp_; }
  double tolerance() const noexcept { return options_.tolerance; }

  Solution solve(double time, std::span<const double> states) noexcept;
  void set_applied(const AppliedInputs& applied) noexcept;
  void set_view_uncertainty(std::span<const ViewUncertainty> of_bodies) noexcept;
  double kkt(double time, std::span<const double> states) noexcept;
  void planned(double time, std::span<double> u) const noexcept;
  void restart() noexcept;
  void plan(int k, std::span<double> u) const noexcept;
  void set_plan(int k, std::span<const double> u) noexcept;
  void set_prediction(const Prediction& prediction) noexcept;
  /// Of the last update, until the next call.
  std::span<const double> predicted_states() noexcept override;

 private:
  using Clock = std::chrono::steady_clock;

  /// What one step came to.
  struct Step {
    double residual = infinity;
    double correction = 0.0;  ///< |du|, in the scale of each input
    int iterations = 0;
    bool finite = true, in_time = true;
    bool whole = false;  ///< neither damped nor shortened, and its active set is settled
    bool taken = false;  ///< costs were not watched
  };
  /// What one pass over a proposed step finds; it leaves in u_next what the step comes to, within the limits.
  struct Proposal {
    double largest = 0.0;   ///< |du|, in the scale of each input
    double residual = 0.0;  ///< of u, where finite
    bool finite = true;     ///< du and H_u are
    bool within_limits = true;
    int votes =
        0;  ///< inputs that are corrected by less than half of what was foreseen of them, less the others
  };

  bool accept(std::span<const double> states) noexcept;
  void set_time(double time) noexcept;
  void write_reference_inputs(int group, double time) noexcept;
  void find_limits(const Agent& agent, std::size_t input, double time, double ahead) noexcept;
  void start() noexcept;
  void extrapolate_plan() noexcept;
  bool is_foreseeable() noexcept;
  void extrapolate_plan(int group) noexcept;
  void remember(const Step& step) noexcept;
  void detach_plan() noexcept;
  Step newton_step() noexcept;
  double* felt(int group, int thread) noexcept;
  template <class PerGroup>
  void linearise(PerGroup&& per_group) noexcept;
  bool solve_alone(bool again, bool begins) noexcept;
  bool is_damped() const noexcept { return std::find(damped_.begin(), damped_.end(), 1) != damped_.end(); }
  Proposal examine(const Krylov::Completion& completion = {}) noexcept;
  Proposal examine(int group, const Krylov::Completion& completion) noexcept;
  std::ptrdiff_t first_stage_end(int group) const noexcept;
  bool slope_is_finite() const noexcept;
  bool update_active_set() noexcept;
  /// How strongly the gradient holds inputs on the limit that is nearer; below 0 it draws them off.
  static NativeLane outward(NativeLane u, NativeLane low, NativeLane high, NativeLane H_u) noexcept {
    return where_negative((high - u) - (u - low), -H_u, H_u);
  }
  void hold_near_limits(int group) noexcept;
  Step project() noexcept;
  double search(Searching who = Searching::all) noexcept;
  bool search_residual() noexcept;
  void differentiate() noexcept;
  double missed() const noexcept;
  void descend(bool settled, Step& step) noexcept;
  void release() noexcept;
  Deadline deadline() const noexcept;
  bool late() const noexcept;
  bool is_stage(int k, std::span<const double> u) const noexcept;
  void write_inputs() noexcept;
  void write_states() noexcept;
  Solution fall_back(double time, Status status) noexcept;

  Ocp ocp_;
  NewtonRiccatiOptions options_;
  std::vector<BodyPotential> potentials_;
  std::vector<SwarmPotential> swarms_;
  InfluenceGraph influence_;
  Groups groups_;
  std::unique_ptr<Couplings> couplings_;
  std::shared_ptr<ThreadPool> pool_;
  PhaseSchedule schedule_;
  Krylov krylov_;
  Descent descent_;

  bool started_ = false, has_plan_ = false;
  bool all_free_ = true;  // no limit is active
  bool limits_move_ = false;
  bool globalising_ = false;   // costs are watched until a step could be taken whole, or the optimum is near
  double watched_ = infinity;  // residual where costs were watched last, since a step was taken
  double time_ = 0.0;
  Clock::time_point begin_{};
  Rows u_vectors_, s_vectors_;
  Rows c_;  // of the team with swarms, else of the one group that each thread is at
  double *u_, *du_, *active_, *H_u_, *low_, *high_, *plan_, *u_start_;
  double* u_next_;                   // where the step leads; once it is taken, where it came from
  double* spare_ = nullptr;          // between updates, when u_ is plan_: where u_ goes once it is to change
  double *plan_before_, *H_before_;  // the plan before plan_, and, in an update, H_u of the one before
  double *per_scale_, *scale_2_;     // of each input, for what is compared with a threshold
  double *s_, *ds_;
  double plan_time_ = 0.0, plan_before_time_ = 0.0;
  int taken_ = 0;  // updates without a break whose steps were taken
  bool foreseen_ = false;
  struct {
    const double* from = nullptr;  // the plan before; none: u is where it is to be
    double ratio = 0.0;            // of the periods
  } foresight_;
  int wait_ = 0, pause_ = 1;  // updates until it is tried again; and after it fails once more
  double corrected_ = 0.0, corrected_before_ = 0.0;  // Step::correction of the last two updates
  int votes_ = 0;                                    // Proposal::votes of the last step that was taken
  std::vector<char> held_;                           // of each group: limits are active in what was foreseen
  std::vector<int> x_at_;                            // of each agent in the stacked state
  std::vector<HeadingErrorLimit> heading_limits_;    // of each agent
  std::vector<char> turned_;                         // of each agent: its reference is seen turned
  std::vector<Prediction> predictions_;  // of each body; room for N + 1 sights of those not controlled
  std::vector<double> x_now_, limits_, u_out_, raw_u_;
  Rows x_out_;  // stage by stage
  enum class States { none, rolled_out, written } states_ = States::none;
  std::vector<double> before_, added_;  // AppliedInputs; empty: never told
  std::vector<char> damped_;            // of each group: a robot's damping is not zero
  std::vector<Proposal> proposals_;     // of each group
};

/// The potentials along s; then per_group(group, what it feels) while that is near in the cache.
template <class PerGroup>
void NewtonUpdate::linearise(PerGroup&& per_group) noexcept {
  couplings_->derive(s_, c_[0], *pool_);
  groups_.each(*pool_, [&](int g, int thread) noexcept { per_group(g, felt(g, thread)); });
}

}  // namespace sightline
