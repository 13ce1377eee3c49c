// Limits of inputs: which of them are active in a step.
#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/solver/newton/stages.hpp"

namespace sightline::newton {
namespace {

using L = NativeLane;

}  // namespace

bool update_active_set(Workspace& w) noexcept {
  const L held = infinity, none = 0.0, one = 1.0;
  L any = none, changed = none;
  for (int i = 0; i < w.groups.layout().u_length; i += L::width) {
    const L u = L::load(w.u + i), du = L::load(w.du + i), low = L::load(w.low + i),
            high = L::load(w.high + i);
    const L H_u = L::load(w.H_u + i), before = L::load(w.active + i);
    const L next = u + du, below = next - low, above = high - next;
    const L leaves = where_negative(above, held, where_negative(below, held, none));
    const L put = where_negative(above, high, where_negative(below, low, u));
    const L stays = where_negative(-outward(u, low, high, H_u), held, none);
    const L active = where_negative(-before, stays, leaves);
    where_negative(-before, u, put).store(w.u + i);
    where_negative(-active, none, du).store(w.du + i);
    active.store(w.active + i);
    const L was = where_negative(-before, one, none), is = where_negative(-active, one, none);
    any = maximum(is, any);
    changed = maximum(absolute(is - was), changed);
  }
  w.all_free = largest(any) == 0.0;
  return largest(changed) != 0.0;
}

void hold_near_limits(Workspace& w, int g) noexcept {
  constexpr double nearby = 0.05;  // of an input's scale
  const Layout::Span its = w.groups.layout().u_of(g);
  for (std::ptrdiff_t i = its.first; i < its.end(); ++i) {
    const double reach = nearby / w.per_scale[i];
    const bool holds = w.H_u[i] > 0 ? w.u[i] < w.low[i] + reach : w.H_u[i] < 0 && w.u[i] > w.high[i] - reach;
    w.active[i] = holds ? infinity : 0.0;
  }
}

void release(Workspace& w) noexcept {
  const int n = w.groups.layout().u_length;
  w.all_free = true;
  for (int i = 0; i < n; ++i) {
    if (w.u[i] != w.low[i] && w.u[i] != w.high[i]) w.active[i] = 0.0;
    w.all_free &= w.active[i] == 0.0;
    w.du[i] = 0.0;
  }
  std::copy_n(w.u, n, w.u_next);
}

}  // namespace sightline::newton
