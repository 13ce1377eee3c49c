// The Newton update on one page: accept the measured states, extrapolate, linearise, backward pass
// per group, couple, project, line search.
#include "sightline/solver/newton/update.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"

namespace sightline::newton {
namespace {

constexpr double trusted_from = 0.02;  // residual below which steps need no line search

/// Search direction of the team.
struct Direction {
  Proposal proposal;
  int iterations = 0;      // Krylov iterations
  bool damped = false;     // a robot's factorisation was damped (Levenberg)
  bool settled = false;    // the active set is that of the computed step
  bool has_start = false;  // u_start holds the start of the step
};

void keep_start(Workspace& w, Direction& d) noexcept {
  if (!d.has_start) std::copy_n(w.u, w.groups.layout().u_length, w.u_start);
  d.has_start = true;
}

/// Combines the steps of single robots to a step of the team.
Krylov::Completion couple(Workspace& w, bool again, bool damped, bool begun) noexcept {
  const WarmStart warm_start = again    ? WarmStart::of_attempts
                               : damped ? WarmStart::none
                                        : WarmStart::of_updates;
  return w.krylov.complete(w.groups, *w.couplings, w.du, w.ds, *w.pool, warm_start, deadline(w), begun);
}

/// Repeats until the active set is unchanged, at most three times.
Direction find_direction(Workspace& w) noexcept {
  constexpr int attempts = 3;
  Direction d;
  // With a deadline the time is checked between the two passes.
  const bool begins = w.krylov.can_begin(*w.couplings) && w.options.deadline == 0.0;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    d.damped = solve_groups(w, attempt > 0, begins);                              // linearise, backward pass
    const Krylov::Completion coupled = couple(w, attempt > 0, d.damped, begins);  // couple
    d.iterations += coupled.iterations;
    d.proposal = evaluate_step(w, coupled);
    if (!d.proposal.finite) break;
    d.settled = d.proposal.within_limits && w.all_free;
    if (d.settled) break;
    keep_start(w, d);
    d.settled = !update_active_set(w);  // project
    if (d.settled || late(w)) break;
  }
  return d;
}

/// Takes the full step.
Step whole_step(Workspace& w, const Direction& d) noexcept {
  std::swap(w.u, w.u_next);
  w.watched = infinity;
  w.votes = d.proposal.votes;
  w.factorised = d.settled;
  return {.correction = d.proposal.largest, .whole = d.settled, .taken = true};
}

/// Takes the step as far as costs decrease.
Step searched_step(Workspace& w, Direction& d) noexcept {
  keep_start(w, d);
  Step step;
  descend(w, d.settled, step);
  release(w);
  w.globalising = w.descent.sure() && d.proposal.residual > trusted_from && !step.whole;
  step.whole &= !d.damped && d.proposal.finite;
  return step;
}

/// Step after one that was not full: projected Newton with a line search, until full steps are
/// reliable again.
Step globalised_step(Workspace& w) noexcept {
  Step step = projected_step(w);
  if (!step.finite) return step;
  release(w);
  w.globalising = w.descent.sure() && step.residual > trusted_from && !step.whole;
  step.in_time = !late(w);
  return step;
}

Step newton_step(Workspace& w) noexcept {
  w.factorised = false;
  if (w.globalising) return globalised_step(w);
  Direction d = find_direction(w);
  const Proposal& p = d.proposal;
  if (!p.finite) {
    if (!slope_is_finite(w)) return {.residual = infinity, .iterations = d.iterations, .finite = false};
    std::fill_n(w.du, w.groups.layout().u_length, 0.0);  // the gradient remains as direction
  }
  w.globalising = !p.finite || d.damped || std::max(p.largest, p.residual) > w.options.step_cap;
  Step step = w.globalising ? searched_step(w, d) : whole_step(w, d);
  step.residual = p.residual;
  step.iterations += d.iterations;
  step.in_time = !late(w);
  return step;
}

}  // namespace

Solution update(Workspace& w, double time, std::span<const double> states) noexcept {
  w.begin = Clock::now();
  const FlushSubnormals guard;
  w.states = States::none;
  w.factorised = false;
  if (!std::isfinite(time) || !accept(w, states)) return fall_back(w, time, Status::invalid_state);
  set_time(w, time);
  const bool anew = !w.started && !w.has_plan;
  const int steps =
      anew ? std::max(w.options.max_newton_steps, w.options.start_steps) : w.options.max_newton_steps;
  if (!w.started) start(w);
  w.started = true;
  extrapolate(w);

  Step step;
  int iterations = 0;
  for (int i = 0; i < steps; ++i) {
    step = newton_step(w);
    iterations += step.iterations;
    if (!step.finite || !step.in_time || step.residual <= w.options.tolerance) break;
  }
  if (!step.finite) return fall_back(w, time, Status::not_finite);
  write_inputs(w);
  w.states = States::rolled_out;
  keep_plan(w, step);
  const Status status = !step.in_time                          ? Status::deadline
                        : step.residual <= w.options.tolerance ? Status::converged
                        : steps == 1 && step.whole             ? Status::stepped
                                                               : Status::iteration_limit;
  return {.u = w.u_out,
          .raw_u = w.raw_u,
          .x = w,
          .status = status,
          .residual = step.residual,
          .iterations = iterations,
          .neighbours = w.couplings->neighbours(),
          .elapsed = std::chrono::duration<double>(Clock::now() - w.begin).count()};
}

/// A step from the plan that is not taken. What a substitution keeps for the next one stays cold.
void warm_up(Workspace& w) noexcept {
  if (!w.started || w.globalising) return;
  const FlushSubnormals guard;
  w.begin = Clock::now();
  w.states = States::none;
  w.factorised = false;
  std::swap(w.H_u, w.u_start);  // keeps H_u of the last update for the next extrapolation
  const bool begins = w.krylov.can_begin(*w.couplings);
  const bool damped = solve_groups(w, true, begins);  // with the neighbours of the last update
  Krylov::Completion coupled;
  if (w.influence.kind == Influence::mutual) coupled = couple(w, false, damped, begins);
  (void)evaluate_step(w, coupled);
  std::swap(w.H_u, w.u_start);
}

double kkt(Workspace& w, double time, std::span<const double> states) noexcept {
  const FlushSubnormals guard;
  w.states = States::none;
  w.factorised = false;
  if (!std::isfinite(time) || !accept(w, states)) return infinity;
  set_time(w, time);
  if (!w.started) {
    const bool planned = w.has_plan;  // keeps it for the next update
    start(w);
    w.has_plan = planned;
  }
  w.groups.roll_out(w.u, w.s, *w.pool);
  w.couplings->find_neighbours(w.s);
  std::swap(w.H_u, w.u_start);  // keeps H_u of the last update for the next extrapolation
  differentiate(w);
  const double residual = evaluate_step(w).residual;
  const bool finite = slope_is_finite(w);
  std::swap(w.H_u, w.u_start);
  return finite ? residual : infinity;
}

}  // namespace sightline::newton
