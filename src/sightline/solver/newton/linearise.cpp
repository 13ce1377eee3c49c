// Linearisation along the roll-out, and the uncoupled solution of each group.
#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"

namespace sightline::newton {
namespace {

using L = NativeLane;

Proposal evaluate_step(Workspace& w, int g, const Krylov::Completion& completion) noexcept {
  const double per_h = 1.0 / w.ocp.horizon().h();
  L step = 0.0, residual = 0.0, beyond = 0.0, not_finite = 0.0, votes = 0.0;
  const Layout::Span its = w.groups.layout().u_of(g);
  const std::ptrdiff_t first_end = first_stage_end(w, g);
  std::ptrdiff_t of = its.first;
  for (std::ptrdiff_t i = its.first; i < its.end(); i += L::width) {
    const std::ptrdiff_t limits = w.limits_move ? i : of;
    const L u = L::load(w.u + i), low = L::load(w.low + limits), high = L::load(w.high + limits);
    L du = L::load(w.du + i);
    if (completion.along != nullptr) {
      du = fma(L(completion.by), L::load(completion.along + i), du);
      du.store(w.du + i);
    }
    const L next = u + du, kept = clamp(next, low, high), per_scale = L::load(w.per_scale + of);
    kept.store(w.u_next + i);
    step = maximum(absolute(du) * per_scale, step);
    beyond = maximum(maximum(next - high, low - next), beyond);
    not_finite = fma(du, L(0.0), not_finite);
    const L H_u = L(per_h) * L::load(w.H_u + i);
    not_finite = fma(H_u, L(0.0), not_finite);
    const L gap = u - clamp(u - H_u * L::load(w.scale_2 + of), low, high);
    residual = maximum(absolute(gap) * per_scale, residual);
    const L foreseen = absolute(u - L::load(w.plan + i)), corrected = absolute(kept - u);
    votes +=
        where_negative(-foreseen, where_negative(L(2.0) * corrected - foreseen, L(1.0), L(-1.0)), L(0.0));
    if ((of += L::width) == first_end) of = its.first;
  }
  double nan = 0.0;
  int sum = 0;
  for (int i = 0; i < L::width; ++i) nan += not_finite[i], sum += static_cast<int>(votes[i]);
  return {largest(step), largest(residual), nan == 0.0, !(largest(beyond) > 0.0), sum};
}

}  // namespace

double* take_couplings(Workspace& w, int group, int thread) noexcept {
  double* const c = w.couplings->has_swarms() ? w.c[0] + w.groups.layout().groups[at(group)].c : w.c[thread];
  w.couplings->take(group, c);
  return c;
}

bool solve_groups(Workspace& w, bool again, bool begins) noexcept {
  const bool gathers = w.couplings->gathers(), foresees = w.extrapolation.from != nullptr;
  const auto roll_out = [&](int g) {
    if (foresees) extrapolate(w, g);
    w.groups.roll_out(g, w.u, w.s);
  };
  if (gathers) {
    w.groups.each(*w.pool, [&](int g, int) noexcept { roll_out(g); });
    if (!again) w.couplings->find_neighbours(w.s);
    w.couplings->gather(w.s, w.c[0], *w.pool);
  }
  w.schedule.run(
      *w.pool,
      [&](int g, int) noexcept {
        if (!gathers) roll_out(g);
      },
      [&](int g, int) noexcept { w.couplings->derive(g, w.s); },
      [&](int g, int thread) noexcept {
        w.damped[at(g)] = w.groups.solve(g, w.u, w.active, take_couplings(w, g, thread), w.H_u, w.du, w.ds,
                                         again ? Damping::last : Damping::none);
      },
      [&](int g, int) noexcept {
        if (begins) w.krylov.begin_direction(g, w.groups, *w.couplings, w.ds);
      },
      [&](int g, int) noexcept {
        if (begins) w.krylov.begin_image(g, *w.couplings);
      });
  if (foresees) w.all_free &= std::find(w.held.begin(), w.held.end(), 1) == w.held.end();
  w.extrapolation = {};
  return is_damped(w);
}

std::ptrdiff_t first_stage_end(const Workspace& w, int g) noexcept {
  const int stage = w.groups.layout().groups[at(g)].nu * w.groups.layout().width;
  const Layout::Span its = w.groups.layout().u_of(g);
  return its.first + (stage % L::width == 0 ? stage : its.length);
}

Proposal evaluate_step(Workspace& w, const Krylov::Completion& completion) noexcept {
  w.groups.each(*w.pool, [&](int g, int) noexcept { w.proposals[at(g)] = evaluate_step(w, g, completion); });
  Proposal all;
  for (const Proposal& p : w.proposals) {
    all.largest = std::max(all.largest, p.largest);
    all.residual = std::max(all.residual, p.residual);
    all.finite &= p.finite;
    all.within_limits &= p.within_limits;
    all.votes += p.votes;
  }
  return all;
}

bool slope_is_finite(const Workspace& w) noexcept {
  return std::all_of(w.H_u, w.H_u + w.groups.layout().u_length, [](double g) { return std::isfinite(g); });
}

void differentiate(Workspace& w) noexcept {
  linearise(w, [&](int g, const double* c) { w.groups.differentiate(g, w.u, w.active, c, w.H_u, w.u_next); });
}

}  // namespace sightline::newton
