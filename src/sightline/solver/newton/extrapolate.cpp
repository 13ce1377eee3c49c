// Initial guess of an update: the previous plan, extrapolated in time.
//
// If references and measurements are smooth, the optimum u*(t) is smooth between changes of the
// active set. The secant of the last two plans reduces the error of the guess from O(dt) to
// O(dt^2). The error of the Newton step falls from O(dt^2) to O(dt^4): a predictor-corrector
// method. Multipliers are extrapolated too, so the active set is mostly correct. With noisy
// measurements the previous plan is the better guess: the inputs vote, by the correction of their
// extrapolation.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"

namespace sightline::newton {
namespace {

using L = NativeLane;

bool may_extrapolate(Workspace& w) noexcept {
  // minimum ratio of successive corrections; a smaller ratio means that the steps converge
  constexpr double steady = 0.5;
  constexpr int longest_pause = 64;
  if (w.extrapolated) {
    if (w.votes >= 0) {
      w.pause = 1;
      return true;
    }
    w.wait = w.pause;
    w.pause = std::min(2 * w.pause, longest_pause);
  }
  if (w.wait > 0) --w.wait;
  return w.wait == 0 && w.corrected >= steady * w.corrected_before;
}

}  // namespace

void extrapolate(Workspace& w) noexcept {
  const double passed = w.time - w.plan_time, before = w.plan_time - w.plan_before_time;
  if (!(passed > 0)) return detach_plan(w);
  std::swap(w.H_u, w.H_before);
  constexpr double farthest = 2.0;  // in previous periods
  w.extrapolated = w.taken >= 2 && passed <= farthest * before && may_extrapolate(w);
  if (!w.extrapolated) return detach_plan(w);
  w.extrapolation = {w.u, passed / before};
  if (w.u == w.plan) w.u = w.spare;
}

void extrapolate(Workspace& w, int group) noexcept {
  const auto& [from, ratio] = w.extrapolation;
  const Layout::Span its = w.groups.layout().u_of(group);
  const L on(infinity), off(0.0);
  L held = 0.0;
  const std::ptrdiff_t first_end = first_stage_end(w, group);
  std::ptrdiff_t of = its.first;
  for (std::ptrdiff_t i = its.first; i < its.end(); i += L::width) {
    const std::ptrdiff_t limits = w.limits_move ? i : of;
    const L u = L::load(from + i), low = L::load(w.low + limits), high = L::load(w.high + limits);
    const L next = u + L(ratio) * (u - L::load(w.plan_before + i));
    L to = clamp(next, low, high), active = where_negative(-absolute(next - to), on, off);
    const L was = w.all_free ? off : L::load(w.active + i);
    if (any_negative(-was)) {
      const L H = L::load(w.H_before + i), ahead = H + L(ratio) * (H - L::load(w.H_u + i));
      to = where_negative(-was, u, to);
      active = where_negative(-was, where_negative(-outward(u, low, high, ahead), on, off), active);
    }
    if (any_negative(-was - active)) active.store(w.active + i);
    to.store(w.u + i);
    held = maximum(held, active);
    if ((of += L::width) == first_end) of = its.first;
  }
  w.held[at(group)] = largest(held) > 0;
}

void keep_plan(Workspace& w, const Step& step) noexcept {
  w.spare = w.plan;
  if (w.time > w.plan_time) {
    std::swap(w.spare, w.plan_before);
    w.plan_before_time = w.plan_time;
  }
  w.plan = w.u;
  w.plan_time = w.time;
  w.taken = step.taken ? w.taken + 1 : 0;
  w.corrected_before = std::exchange(w.corrected, step.correction);
}

void detach_plan(Workspace& w) noexcept {
  if (w.u != w.plan) return;
  w.u = w.spare;
  std::copy_n(w.plan, w.groups.layout().u_length, w.u);
}

}  // namespace sightline::newton
