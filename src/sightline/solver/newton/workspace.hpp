/// All that a Newton update works with: the problem, the iterate, and memory that is sized once.
#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <vector>

#include "sightline/base/no_value.hpp"
#include "sightline/potential/heading_error_limit.hpp"
#include "sightline/solver/newton/descent.hpp"
#include "sightline/solver/newton/newton_riccati.hpp"
#include "sightline/solver/newton/phase_schedule.hpp"

namespace sightline::newton {

using Clock = std::chrono::steady_clock;

/// The outcome of one step.
struct Step {
  double residual = infinity;
  double correction = 0.0;  ///< |du|, in the scale of each input
  int iterations = 0;       ///< of the Krylov method
  bool finite = true, in_time = true;
  bool whole = false;  ///< neither damped nor shortened, and its active set is settled
  bool taken = false;  ///< without a line search
};

/// The findings of one pass over a proposed step.
struct Proposal {
  double largest = 0.0;   ///< |du|, in the scale of each input
  double residual = 0.0;  ///< of u, where finite
  bool finite = true;     ///< du and H_u are
  bool within_limits = true;
  int votes = 0;  ///< inputs corrected by less than half of their extrapolation, less the others
};

/// State of the trajectory in Workspace::x_out.
enum class States { none, rolled_out, written };

/// Vectors of inputs (u) and of seen bodies (s) have the layout of Groups. One thread at a time.
struct Workspace final : PredictedStates::Writer {
  /// @throws std::invalid_argument naming an option out of its range
  Workspace(Ocp problem, const NewtonRiccatiOptions& chosen);
  Workspace(const Workspace&) = delete;  // its pointers point into its own memory
  Workspace& operator=(const Workspace&) = delete;

  /// The trajectory of the last update, until the next call.
  std::span<const double> predicted_states() noexcept override;

  Ocp ocp;
  NewtonRiccatiOptions options;
  std::vector<BodyPotential> potentials;
  std::vector<SwarmPotential> swarms;
  InfluenceGraph influence;
  Groups groups;
  std::unique_ptr<Couplings> couplings;
  std::shared_ptr<ThreadPool> pool;
  PhaseSchedule schedule;
  Krylov krylov;
  Descent descent;

  bool started = false, has_plan = false;
  bool all_free = true;  // no limit is active
  bool limits_move = false;
  bool globalising = false;   // costs are watched until a step could be taken whole, or the optimum is near
  double watched = infinity;  // residual where costs were watched last, since a step was taken
  double time = 0.0;
  Clock::time_point begin{};
  Rows u_vectors, s_vectors;
  Rows c;  // of the team with swarms, else of the one group that each thread is at
  double *u, *du, *active, *H_u, *low, *high, *plan, *u_start;
  double* u_next;                  // where the step leads; once it is taken, where it came from
  double* spare = nullptr;         // between updates, when u is plan: where u goes once it is to change
  double *plan_before, *H_before;  // the plan before plan, and, in an update, H_u of the one before
  double *per_scale, *scale_2;     // of each input, for what is compared with a threshold
  double *s, *ds;
  double plan_time = 0.0, plan_before_time = 0.0;
  int taken = 0;  // updates without a break whose steps were taken
  bool extrapolated = false;
  struct {
    const double* from = nullptr;  // the plan before; none: u is where it is to be
    double ratio = 0.0;            // of the periods
  } extrapolation;
  int wait = 0, pause = 1;  // updates until it is tried again; and after it fails once more
  double corrected = 0.0, corrected_before = 0.0;  // Step::correction of the last two updates
  int votes = 0;                                   // Proposal::votes of the last step that was taken
  std::vector<char> held;                          // of each group: limits are active in what was foreseen
  std::vector<int> x_at;                           // of each agent in the stacked state
  std::vector<HeadingErrorLimit> heading_limits;   // of each agent
  std::vector<char> turned;                        // of each agent: its reference is seen turned
  std::vector<Prediction> predictions;  // of each body; room for N + 1 sights of those not controlled
  std::vector<double> x_now, limits, u_out, raw_u;
  Rows x_out;                            // stage by stage
  States states = States::none;          // of x_out
  std::vector<double> previous, offset;  // AppliedInputs; empty: none was set
  std::vector<char> damped;              // of each group: a robot's damping is not zero
  std::vector<Proposal> proposals;       // of each group
};

}  // namespace sightline::newton
