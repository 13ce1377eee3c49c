// Unreliable steps: line searches on the cost and on the residual, and projected Newton.
#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"

namespace sightline::newton {
namespace {

/// Line search from u_start along du. @return the smallest step length of a unit
double line_search(Workspace& w, Searching who = Searching::all) noexcept {
  return w.descent.search(w.groups, *w.couplings, w.u_start, w.du, w.low, w.high, w.u, w.s, *w.pool, who,
                          deadline(w));
}

/// Optimality violation of u: the sum of squares of the terms whose maximum is `residual`.
double optimality_gap(const Workspace& w) noexcept {
  const double per_h = 1.0 / w.ocp.horizon().h();
  double sum = 0.0;
  for (int i = 0; i < w.groups.layout().u_length; ++i) {
    const double gap = w.u[i] - clamp(w.u[i] - per_h * w.H_u[i] * w.scale_2[i], w.low[i], w.high[i]);
    sum += square(gap * w.per_scale[i]);
  }
  return sum;
}

/// Line search from u_start along du on the optimality violation of all robots.
/// @return whether a step decreases it; if not, u is u_start
bool line_search_residual(Workspace& w) noexcept {
  constexpr double shortest = 0.05, enough = 0.2;
  const int n = w.groups.layout().u_length;
  const double before = optimality_gap(w);
  bool found = false;
  for (double alpha = 1.0; !found && alpha > shortest && !late(w); alpha *= 0.5) {
    for (int i = 0; i < n; ++i) w.u[i] = clamp(w.u_start[i] + alpha * w.du[i], w.low[i], w.high[i]);
    w.groups.roll_out(w.u, w.s, *w.pool);
    differentiate(w);
    found = optimality_gap(w) < (1.0 - enough * alpha) * before;
  }
  if (found) return true;
  std::copy_n(w.u_start, n, w.u);
  w.groups.roll_out(w.u, w.s, *w.pool);
  differentiate(w);
  return false;
}

}  // namespace

Step projected_step(Workspace& w) noexcept {
  constexpr double min_decrease = 0.9;  // ratio of residuals above which the cost search has stalled
  const int n = w.groups.layout().u_length;
  std::copy_n(w.u, n, w.u_start);
  w.groups.roll_out(w.u, w.s, *w.pool);
  w.couplings->find_neighbours(w.s);
  linearise(w, [&](int g, const double* c) {
    w.groups.differentiate(g, w.u, w.active, c, w.H_u, w.du);
    hold_near_limits(w, g);
    w.damped[at(g)] = w.groups.solve(g, w.u, w.active, c, w.H_u, w.du, w.ds);
  });
  const bool damped = is_damped(w);
  Step result;
  const Krylov::Completion completion =
      w.krylov.complete(w.groups, *w.couplings, w.du, w.ds, *w.pool, WarmStart::none, deadline(w));
  result.iterations = completion.iterations;
  result.residual = evaluate_step(w, completion).residual;
  result.finite = slope_is_finite(w);
  if (!result.finite) return result;
  for (int i = 0; i < n; ++i) {
    if (w.active[i] != 0.0) w.du[i] = (w.H_u[i] > 0 ? w.low[i] : w.high[i]) - w.u[i];
  }
  const bool stuck = !w.descent.sure() && result.residual > min_decrease * w.watched;
  w.watched = result.residual;
  if (stuck && line_search_residual(w)) return result;
  const double alpha = line_search(w);
  if (alpha == 0.0) {
    std::copy_n(w.u, n, w.u_start);
    for (int i = 0; i < n; ++i) w.du[i] = -0.5 / w.ocp.horizon().h() * w.H_u[i] * w.scale_2[i];
    line_search(w, Searching::who_stood);
  }
  result.whole = alpha >= 1.0 && !damped;
  return result;
}

void descend(Workspace& w, bool settled, Step& step) noexcept {
  constexpr double far_enough = 0.25;  // of the full step
  for (int i = 0; i < w.groups.layout().u_length; ++i) w.du[i] = w.u[i] + w.du[i] - w.u_start[i];
  const double alpha = line_search(w);
  if ((alpha < far_enough || !settled || (w.descent.sure() && !w.descent.fell())) && !late(w))
    step.iterations += projected_step(w).iterations;
  step.whole = alpha >= 1.0 && settled;
}

}  // namespace sightline::newton
