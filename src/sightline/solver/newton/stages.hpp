/// Stages of a Newton update: free functions over its workspace, in the order of update.cpp. None
/// allocates, locks or throws.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "sightline/solver/newton/workspace.hpp"

namespace sightline::newton {

// Prepare: prepare.cpp
/// Copies the measured states of all bodies (nx) with normalised headings. @return false if a state
/// is rejected
bool accept(Workspace& w, std::span<const double> states) noexcept;
/// Sets references, limits and the motion of uncontrolled bodies along the horizon from `time` [s].
void set_time(Workspace& w, double time) noexcept;
/// Writes w.limits: u_min before u_max of a robot's inputs, `ahead` [s] after an update at `time`;
/// its inputs begin at `input`.
void find_limits(Workspace& w, const Agent& agent, std::size_t input, double time, double ahead) noexcept;
/// Initialises the first update: no limit is active; only the plan of earlier updates is kept.
void start(Workspace& w) noexcept;

// The initial guess: extrapolate.cpp
/// Decides whether the update starts at the extrapolated plan; the groups write it during roll-out.
void extrapolate(Workspace& w) noexcept;
/// Extrapolates the inputs of one group.
void extrapolate(Workspace& w, int group) noexcept;
/// Stores u as the plan, and the previous plan, for the extrapolation of the next update.
void keep_plan(Workspace& w, const Step& step) noexcept;
/// Gives u its own memory, so that u can change while the plan is kept.
void detach_plan(Workspace& w) noexcept;

// Linearise and solve group by group: linearise.cpp
/// Rolls out, linearises and solves each group without coupling (block Riccati); includes the first
/// coupling iteration if `begins`. An attempt with `again` keeps the swarm pairs and the damping.
/// @return whether a robot is damped
bool solve_groups(Workspace& w, bool again, bool begins) noexcept;
/// Adds the coupling correction to du and writes u_next, the step clamped to the limits. @return
/// residual and size of the step
Proposal evaluate_step(Workspace& w, const Krylov::Completion& completion = {}) noexcept;
/// Whether H_u is finite.
bool slope_is_finite(const Workspace& w) noexcept;
/// Computes H_u at the last roll-out; overwrites u_next.
void differentiate(Workspace& w) noexcept;
/// End of a group's first stage. Scales and fixed limits are equal at all stages, so the first
/// stage's values stay cached.
std::ptrdiff_t first_stage_end(const Workspace& w, int g) noexcept;
/// Gradients and Hessians that act on a group, from the last derivatives of the potentials.
double* take_couplings(Workspace& w, int group, int thread) noexcept;
/// Whether a robot's factorisation was damped.
inline bool is_damped(const Workspace& w) noexcept {
  return std::find(w.damped.begin(), w.damped.end(), 1) != w.damped.end();
}
/// Evaluates the potentials along s, then per_group(group, c) while c of the group is cached.
template <class PerGroup>
void linearise(Workspace& w, PerGroup&& per_group) noexcept {
  w.couplings->derive(w.s, w.c[0], *w.pool);
  w.groups.each(*w.pool, [&](int g, int thread) noexcept { per_group(g, take_couplings(w, g, thread)); });
}

// Limits: active_set.cpp
/// Component of the gradient that holds inputs on the nearer limit; negative: it drives them off.
inline NativeLane outward(NativeLane u, NativeLane low, NativeLane high, NativeLane H_u) noexcept {
  return where_negative((high - u) - (u - low), -H_u, H_u);
}
/// Activates inputs of a group that the gradient holds near a limit.
void hold_near_limits(Workspace& w, int group) noexcept;
/// Clamps inputs that leave their limits and activates them; frees active inputs that the gradient
/// drives back. @return whether the set changed
bool update_active_set(Workspace& w) noexcept;
/// After a line search: u is the start of the next step; all inputs are free except those on their
/// limits.
void release(Workspace& w) noexcept;

// Unreliable steps: line_search.cpp
/// Projected Newton step from u (Bertsekas 1982), as far as costs decrease.
Step projected_step(Workspace& w) noexcept;
/// Line search from u_start towards the step; falls back to projected Newton if the step is short.
void descend(Workspace& w, bool settled, Step& step) noexcept;

// Time and results: output.cpp
/// Time at which the update must end.
Deadline deadline(const Workspace& w) noexcept;
/// Whether the deadline has passed.
bool late(const Workspace& w) noexcept;
/// Writes the inputs to apply, and the inputs before clamping.
void write_inputs(Workspace& w) noexcept;
/// Returns the last good plan's input at this time, clamped to the limits; zero without a plan.
Solution fall_back(Workspace& w, double time, Status status) noexcept;
/// Writes the trajectory of the last roll-out, stage by stage, to w.x_out.
void write_states(Workspace& w) noexcept;

}  // namespace sightline::newton
