/// Stages of a Newton update, free functions over its workspace, in the order of update.cpp. None allocates, locks or throws.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "sightline/solver/newton/workspace.hpp"

namespace sightline::newton {

// Prepare: prepare.cpp
/// Takes the measured states of all bodies (nx), headings normalised. @return false: a state is refused
bool accept(Workspace& w, std::span<const double> states) noexcept;
/// References, limits and the motion of bodies that are not controlled, along the horizon from `time` [s].
void set_time(Workspace& w, double time) noexcept;
/// Writes w.limits: u_min before u_max of a robot's inputs, `ahead` [s] after an update at `time`; its inputs begin at `input`.
void find_limits(Workspace& w, const Agent& agent, std::size_t input, double time, double ahead) noexcept;
/// A first update: no limit is active, nothing of earlier updates is left but the plan.
void start(Workspace& w) noexcept;

// The initial guess: extrapolate.cpp
/// Decides whether the update begins at the extrapolated plan; the groups write it as they are rolled out.
void extrapolate(Workspace& w) noexcept;
/// Extrapolates the inputs of one group.
void extrapolate(Workspace& w, int group) noexcept;
/// Keeps u as the plan, and the plan before, for the extrapolation of the next update.
void keep_plan(Workspace& w, const Step& step) noexcept;
/// Gives u memory of its own, so that it may change and the plan stays.
void detach_plan(Workspace& w) noexcept;

// Linearise and solve group by group: linearise.cpp
/// Rolls out, linearises and solves each group by itself (block Riccati); with the first iteration of the couplings if `begins`. An attempt
/// `again` keeps the neighbours and the damping. @return whether a robot is damped
bool solve_groups(Workspace& w, bool again, bool begins) noexcept;
/// Adds the couplings' completion to du; writes u_next, the step within the limits; residual and size of the step.
Proposal evaluate_step(Workspace& w, const Krylov::Completion& completion = {}) noexcept;
/// Whether H_u is finite.
bool slope_is_finite(const Workspace& w) noexcept;
/// H_u at the last roll-out; u_next is overwritten.
void differentiate(Workspace& w) noexcept;
/// End of the first stage of a group: scales, and limits that do not move, are the same at each stage, and those of the first stay in the cache.
std::ptrdiff_t first_stage_end(const Workspace& w, int g) noexcept;
/// Gradients and Hessians of what a group feels, of the potentials' last derivatives.
double* take_couplings(Workspace& w, int group, int thread) noexcept;
/// Whether a robot's factorisation was damped.
inline bool is_damped(const Workspace& w) noexcept {
  return std::find(w.damped.begin(), w.damped.end(), 1) != w.damped.end();
}
/// The potentials along s; then per_group(group, what it feels) while that is near in the cache.
template <class PerGroup>
void linearise(Workspace& w, PerGroup&& per_group) noexcept {
  w.couplings->derive(w.s, w.c[0], *w.pool);
  w.groups.each(*w.pool, [&](int g, int thread) noexcept { per_group(g, take_couplings(w, g, thread)); });
}

// Limits: active_set.cpp
/// How strongly the gradient holds inputs on the limit that is nearer; below 0 it draws them off.
inline NativeLane outward(NativeLane u, NativeLane low, NativeLane high, NativeLane H_u) noexcept {
  return where_negative((high - u) - (u - low), -H_u, H_u);
}
/// Inputs of a group that the gradient holds near a limit become active.
void hold_near_limits(Workspace& w, int group) noexcept;
/// Puts inputs that leave their limits on them, active, and frees active ones that the gradient draws back. @return whether the set changed
bool update_active_set(Workspace& w) noexcept;
/// After a line search: u is where the next step begins, free but for inputs on their limits.
void release(Workspace& w) noexcept;

// Steps that cannot be trusted: line_search.cpp
/// A step of projected Newton from u (Bertsekas 1982), as far as costs fall.
Step projected_step(Workspace& w) noexcept;
/// A line search from u_start towards the step; projected Newton where that is not far.
void descend(Workspace& w, bool settled, Step& step) noexcept;

// Time and results: output.cpp
/// When the update must end.
Deadline deadline(const Workspace& w) noexcept;
/// Whether the deadline has passed.
bool late(const Workspace& w) noexcept;
/// The inputs to apply, and those before they were clamped.
void write_inputs(Workspace& w) noexcept;
/// The input that the last good plan has for this time, within the limits; zero before there is a plan.
Solution fall_back(Workspace& w, double time, Status status) noexcept;
/// The trajectory of the last roll-out, stage by stage, in w.x_out.
void write_states(Workspace& w) noexcept;

}  // namespace sightline::newton
