/// Workspace of the Newton update: the problem, the iterate, and memory that is allocated once.
#pragma once

#include <chrono>
#include <limits>
#include <memory>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/potentials.hpp"
#include "sightline/solver/newton/descent.hpp"
#include "sightline/solver/newton/phase_schedule.hpp"
#include "sightline/solvers.hpp"

namespace sightline::newton {

using Clock = std::chrono::steady_clock;

/// Result of one Newton step.
struct Step {
  double residual = infinity;
  double correction = 0.0;  ///< |du|, in the scale of each input
  int iterations = 0;       ///< Krylov iterations
  bool finite = true, in_time = true;
  bool whole = false;  ///< neither damped nor shortened, with a settled active set
  bool taken = false;  ///< accepted without a line search
};

/// Result of one pass over a proposed step.
struct Proposal {
  double largest = 0.0;   ///< |du|, in the scale of each input
  double residual = 0.0;  ///< of u, where finite
  bool finite = true;     ///< of du and H_u
  bool within_limits = true;
  int votes = 0;  ///< inputs whose correction is below half of their extrapolation, minus the others
};

/// State of the trajectory in Workspace::x_out.
enum class States { none, rolled_out, written };

/// Vectors of inputs (u) and of Sight components (s) have the layout of Groups. Not thread-safe.
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
  PhaseSchedule<5> schedule;  // the functions of solve_groups()
  Krylov krylov;
  Descent descent;

  bool started = false, has_plan = false;
  bool all_free = true;  // no limit is active
  bool limits_move = false;
  bool globalising = false;   // line search active until a full step is possible, or near the optimum
  double watched = infinity;  // residual at the last line search since an accepted step
  double time = 0.0;
  Clock::time_point begin{};
  Rows u_vectors, s_vectors;
  Rows c;  // of the team with swarms, else of the current group of each thread
  double *u, *du, *active, *H_u, *low, *high, *plan, *u_start;
  double* u_next;                  // target of the step; after acceptance its start
  bool factorised = false;         // the groups hold the undamped factorisation at u_next
  double* spare = nullptr;         // between updates, when u is plan: next buffer of u
  double *plan_before, *H_before;  // plan before `plan`; during an update, H_u of the previous one
  double *per_scale, *scale_2;     // per input, for comparison with a threshold
  double *s, *ds;
  double plan_time = 0.0, plan_before_time = 0.0;
  int taken = 0;  // consecutive updates with an accepted step
  bool extrapolated = false;
  struct {
    const double* from = nullptr;  // the previous plan; null: u is already extrapolated
    double ratio = 0.0;            // of the update periods
  } extrapolation;
  int wait = 0, pause = 1;  // updates until the next extrapolation; pause after the next failure
  double corrected = 0.0, corrected_before = 0.0;  // Step::correction of the last two updates
  int votes = 0;                                   // Proposal::votes of the last accepted step
  std::vector<char> held;                          // per group: limits are active in the extrapolated plan
  std::vector<int> x_at;                           // offset of each agent in the stacked state
  std::vector<HeadingErrorLimit> heading_limits;   // of each agent
  std::vector<char> turned;                        // per agent: the heading-error limit changed its reference
  std::vector<Prediction> predictions;  // per body; capacity of N + 1 Sights for uncontrolled bodies
  std::vector<double> x_now, limits, u_out, raw_u;
  Rows x_out;                            // stage by stage
  States states = States::none;          // of x_out
  std::vector<double> previous, offset;  // AppliedInputs; empty: none was set
  std::vector<char> damped;              // per group: the damping of a robot is not zero
  std::vector<Proposal> proposals;       // of each group
};

}  // namespace sightline::newton
