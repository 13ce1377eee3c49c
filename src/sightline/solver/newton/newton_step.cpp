// The step of a NewtonUpdate: linearised, solved, examined, taken or searched along.
#include <algorithm>
#include <cmath>

#include "sightline/base/index.hpp"
#include "sightline/base/no_value.hpp"
#include "sightline/solver/newton/newton_update.hpp"

namespace sightline {
namespace {

using L = NativeLane;

}  // namespace

/// Gradients and Hessians of what a group feels, of the potentials' last derivatives.
double* NewtonUpdate::felt(int group, int thread) noexcept {
  double* const c = couplings_->has_swarms() ? c_[0] + groups_.layout().groups[at(group)].c : c_[thread];
  couplings_->take(group, c);
  return c;
}

/// The step of each robot by itself, from the roll-out of u on; with the first iteration of the couplings where it `begins`.
/// An attempt after the first keeps the neighbours, and the damping, which comes from zero in many factorisations.
/// @return whether a robot is damped
bool NewtonUpdate::solve_alone(bool again, bool begins) noexcept {
  const bool gathers = couplings_->gathers(), foresees = foresight_.from != nullptr;
  const auto roll_out = [&](int g) {
    if (foresees) extrapolate_plan(g);
    groups_.roll_out(g, u_, s_);
  };
  if (gathers) {
    groups_.each(*pool_, [&](int g, int) noexcept { roll_out(g); });
    if (!again) couplings_->find_neighbours(s_);
    couplings_->gather(s_, c_[0], *pool_);
  }
  schedule_.run(
      *pool_,
      [&](int g, int) noexcept {
        if (!gathers) roll_out(g);
      },
      [&](int g, int) noexcept { couplings_->derive(g, s_); },
      [&](int g, int thread) noexcept {
        damped_[at(g)] = groups_.solve(g, u_, active_, felt(g, thread), H_u_, du_, ds_,
                                       again ? Damping::last : Damping::none);
      },
      [&](int g, int) noexcept {
        if (begins) krylov_.begin_direction(g, groups_, *couplings_, ds_);
      },
      [&](int g, int) noexcept {
        if (begins) krylov_.begin_image(g, *couplings_);
      });
  if (foresees) all_free_ &= std::find(held_.begin(), held_.end(), 1) == held_.end();
  foresight_ = {};
  return is_damped();
}

/// Scales, and limits that do not move, are the same at each stage: those of the first stay in the cache, where its rows are whole packs.
std::ptrdiff_t NewtonUpdate::first_stage_end(int g) const noexcept {
  const int stage = groups_.layout().groups[at(g)].nu * groups_.layout().width;
  const Layout::Span its = groups_.layout().u_of(g);
  return its.first + (stage % L::width == 0 ? stage : its.length);
}

/// Of u and du, to which is added what completes it.
NewtonUpdate::Proposal NewtonUpdate::examine(const Krylov::Completion& completion) noexcept {
  groups_.each(*pool_, [&](int g, int) noexcept { proposals_[at(g)] = examine(g, completion); });
  Proposal all;
  for (const Proposal& p : proposals_) {
    all.largest = std::max(all.largest, p.largest);
    all.residual = std::max(all.residual, p.residual);
    all.finite &= p.finite;
    all.within_limits &= p.within_limits;
    all.votes += p.votes;
  }
  return all;
}

NewtonUpdate::Proposal NewtonUpdate::examine(int g, const Krylov::Completion& completion) noexcept {
  const double per_h = 1.0 / ocp_.horizon().h();
  L step = 0.0, residual = 0.0, beyond = 0.0, not_finite = 0.0, votes = 0.0;
  const Layout::Span its = groups_.layout().u_of(g);
  const std::ptrdiff_t first_end = first_stage_end(g);
  std::ptrdiff_t of = its.first;
  for (std::ptrdiff_t i = its.first; i < its.end(); i += L::width) {
    const std::ptrdiff_t limits = limits_move_ ? i : of;
    const L u = L::load(u_ + i), low = L::load(low_ + limits), high = L::load(high_ + limits);
    L du = L::load(du_ + i);
    if (completion.along != nullptr) {
      du = fma(L(completion.by), L::load(completion.along + i), du);
      du.store(du_ + i);
    }
    const L next = u + du, kept = clamp(next, low, high), per_scale = L::load(per_scale_ + of);
    kept.store(u_next_ + i);
    step = maximum(absolute(du) * per_scale, step);
    beyond = maximum(maximum(next - high, low - next), beyond);
    not_finite = fma(du, L(0.0), not_finite);
    const L H_u = L(per_h) * L::load(H_u_ + i);
    not_finite = fma(H_u, L(0.0), not_finite);
    const L gap = u - clamp(u - H_u * L::load(scale_2_ + of), low, high);
    residual = maximum(absolute(gap) * per_scale, residual);
    const L foreseen = absolute(u - L::load(plan_ + i)), corrected = absolute(kept - u);
    votes +=
        where_negative(-foreseen, where_negative(L(2.0) * corrected - foreseen, L(1.0), L(-1.0)), L(0.0));
    if ((of += L::width) == first_end) of = its.first;
  }
  double nan = 0.0;
  int sum = 0;
  for (int i = 0; i < L::width; ++i) nan += not_finite[i], sum += static_cast<int>(votes[i]);
  return {largest(step), largest(residual), nan == 0.0, !(largest(beyond) > 0.0), sum};
}

bool NewtonUpdate::slope_is_finite() const noexcept {
  return std::all_of(H_u_, H_u_ + groups_.layout().u_length, [](double g) { return std::isfinite(g); });
}

/// Inputs that want to leave their limits are put on them and become active; active ones that want back are freed.
/// @return whether the set changed
bool NewtonUpdate::update_active_set() noexcept {
  const L held = infinity, none = 0.0, one = 1.0;
  L any = none, changed = none;
  for (int i = 0; i < groups_.layout().u_length; i += L::width) {
    const L u = L::load(u_ + i), du = L::load(du_ + i), low = L::load(low_ + i), high = L::load(high_ + i);
    const L H_u = L::load(H_u_ + i), before = L::load(active_ + i);
    const L next = u + du, below = next - low, above = high - next;
    const L leaves = where_negative(above, held, where_negative(below, held, none));
    const L put = where_negative(above, high, where_negative(below, low, u));
    const L stays = where_negative(-outward(u, low, high, H_u), held, none);
    const L active = where_negative(-before, stays, leaves);
    where_negative(-before, u, put).store(u_ + i);
    where_negative(-active, none, du).store(du_ + i);
    active.store(active_ + i);
    const L was = where_negative(-before, one, none), is = where_negative(-active, one, none);
    any = maximum(is, any);
    changed = maximum(absolute(is - was), changed);
  }
  all_free_ = largest(any) == 0.0;
  return largest(changed) != 0.0;
}

/// Inputs of a group that the gradient holds near a limit are to go there.
void NewtonUpdate::hold_near_limits(int g) noexcept {
  constexpr double nearby = 0.05;  // of an input's scale
  const Layout::Span its = groups_.layout().u_of(g);
  for (std::ptrdiff_t i = its.first; i < its.end(); ++i) {
    const double reach = nearby / per_scale_[i];
    const bool holds = H_u_[i] > 0 ? u_[i] < low_[i] + reach : H_u_[i] < 0 && u_[i] > high_[i] - reach;
    active_[i] = holds ? infinity : 0.0;
  }
}

/// A step of projected Newton from u (Bertsekas 1982), as far as costs fall: inputs that the gradient holds near a limit go there, the
/// others by a step of their own. Whoever finds no way goes down the gradient. Without one cost for all, what lowers one
/// robot's may raise another's: where the residual stood, it is searched for itself.
NewtonUpdate::Step NewtonUpdate::project() noexcept {
  constexpr double min_decrease = 0.9;  // of the residual before, that costs alone have not led on
  const int n = groups_.layout().u_length;
  std::copy_n(u_, n, u_start_);
  groups_.roll_out(u_, s_, *pool_);
  couplings_->find_neighbours(s_);
  linearise([&](int g, const double* c) {
    groups_.differentiate(g, u_, active_, c, H_u_, du_);
    hold_near_limits(g);
    damped_[at(g)] = groups_.solve(g, u_, active_, c, H_u_, du_, ds_);
  });
  const bool damped = is_damped();
  Step result;
  const Krylov::Completion completion =
      krylov_.complete(groups_, *couplings_, du_, ds_, *pool_, WarmStart::none, deadline());
  result.iterations = completion.iterations;
  result.residual = examine(completion).residual;
  result.finite = slope_is_finite();
  if (!result.finite) return result;
  for (int i = 0; i < n; ++i) {
    if (active_[i] != 0.0) du_[i] = (H_u_[i] > 0 ? low_[i] : high_[i]) - u_[i];
  }
  const bool stuck = !descent_.sure() && result.residual > min_decrease * watched_;
  watched_ = result.residual;
  if (stuck && search_residual()) return result;
  const double alpha = search();
  if (alpha == 0.0) {
    std::copy_n(u_, n, u_start_);
    for (int i = 0; i < n; ++i) du_[i] = -0.5 / ocp_.horizon().h() * H_u_[i] * scale_2_[i];
    search(Searching::who_stood);
  }
  result.whole = alpha >= 1.0 && !damped;
  return result;
}

/// From u_start along du, the team's way of it. @return the shortest way of a robot, in steps
double NewtonUpdate::search(Searching who) noexcept {
  return descent_.search(groups_, *couplings_, u_start_, du_, low_, high_, u_, s_, *pool_, who, deadline());
}

/// From u_start along du as far as the conditions of optimality, all robots' together, are missed by less.
/// @return whether they are anywhere; if not, u is u_start
bool NewtonUpdate::search_residual() noexcept {
  constexpr double shortest = 0.05, enough = 0.2;
  const int n = groups_.layout().u_length;
  const double before = missed();
  bool found = false;
  for (double alpha = 1.0; !found && alpha > shortest && !late(); alpha *= 0.5) {
    for (int i = 0; i < n; ++i) u_[i] = clamp(u_start_[i] + alpha * du_[i], low_[i], high_[i]);
    groups_.roll_out(u_, s_, *pool_);
    differentiate();
    found = missed() < (1.0 - enough * alpha) * before;
  }
  if (found) return true;
  std::copy_n(u_start_, n, u_);
  groups_.roll_out(u_, s_, *pool_);
  differentiate();
  return false;
}

/// H_u at the last roll-out; u_next is overwritten.
void NewtonUpdate::differentiate() noexcept {
  linearise([&](int g, const double* c) { groups_.differentiate(g, u_, active_, c, H_u_, u_next_); });
}

/// By how much u misses the conditions of optimality: the sum of squares of what `residual` is the largest of.
double NewtonUpdate::missed() const noexcept {
  const double per_h = 1.0 / ocp_.horizon().h();
  double sum = 0.0;
  for (int i = 0; i < groups_.layout().u_length; ++i) {
    const double gap = u_[i] - clamp(u_[i] - per_h * H_u_[i] * scale_2_[i], low_[i], high_[i]);
    sum += square(gap * per_scale_[i]);
  }
  return sum;
}

/// Goes from u_start towards the step only as far as costs fall. Where that is not far, on by projected Newton. The step is whole where it
/// could be taken as it was.
void NewtonUpdate::descend(bool settled, Step& step) noexcept {
  constexpr double far_enough = 0.25;  // of the step
  for (int i = 0; i < groups_.layout().u_length; ++i) du_[i] = u_[i] + du_[i] - u_start_[i];
  const double alpha = search();
  if ((alpha < far_enough || !settled || (descent_.sure() && !descent_.fell())) && !late())
    step.iterations += project().iterations;
  step.whole = alpha >= 1.0 && settled;
}

/// What was watched is where the next step begins: free but for inputs on their limits.
void NewtonUpdate::release() noexcept {
  const int n = groups_.layout().u_length;
  all_free_ = true;
  for (int i = 0; i < n; ++i) {
    if (u_[i] != low_[i] && u_[i] != high_[i]) active_[i] = 0.0;
    all_free_ &= active_[i] == 0.0;
    du_[i] = 0.0;
  }
  std::copy_n(u_, n, u_next_);
}

NewtonUpdate::Step NewtonUpdate::newton_step() noexcept {
  constexpr int attempts = 3;
  constexpr double near = 0.02;  // residual from which on steps are trusted again
  Step result;
  if (globalising_) {
    result = project();
    if (!result.finite) return result;
    release();
    globalising_ = descent_.sure() && result.residual > near && !result.whole;
    result.in_time = !late();
    return result;
  }
  Proposal proposal;
  bool damped = false, settled = false;
  bool started_from = false;  // u_start is known
  // Else time is looked at in between.
  const bool begins = krylov_.can_begin(*couplings_) && options_.deadline == 0.0;
  const auto keep_start = [&] {
    if (!started_from) std::copy_n(u_, groups_.layout().u_length, u_start_);
    started_from = true;
  };
  for (int attempt = 0; attempt < attempts; ++attempt) {
    damped = solve_alone(attempt > 0, begins);
    const WarmStart warm_start = attempt > 0 ? WarmStart::of_attempts
                                 : damped    ? WarmStart::none
                                             : WarmStart::of_updates;
    const Krylov::Completion completion =
        krylov_.complete(groups_, *couplings_, du_, ds_, *pool_, warm_start, deadline(), begins);
    result.iterations += completion.iterations;
    proposal = examine(completion);
    result.residual = proposal.residual;
    result.finite = proposal.finite;
    if (!proposal.finite) break;
    settled = proposal.within_limits && all_free_;
    if (settled) break;
    keep_start();
    settled = !update_active_set();
    if (settled || late()) break;
  }
  if (!proposal.finite) {
    if (!slope_is_finite()) {
      result.residual = infinity;
      return result;
    }
    std::fill_n(du_, groups_.layout().u_length, 0.0);  // the gradient is left
    result.finite = true;
  }
  globalising_ =
      !proposal.finite || damped || std::max(proposal.largest, proposal.residual) > options_.step_cap;
  if (globalising_) {
    keep_start();
    descend(settled, result);
    release();
    globalising_ = descent_.sure() && proposal.residual > near && !result.whole;
    result.whole &= !damped && proposal.finite;
  } else {
    std::swap(u_, u_next_);
    watched_ = infinity;
    result.taken = true;
    votes_ = proposal.votes;
    result.correction = proposal.largest;
    result.whole = settled;
  }
  result.in_time = !late();
  return result;
}

}  // namespace sightline
