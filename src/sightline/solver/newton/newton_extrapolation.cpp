// The guess from which an update begins: the plan before, carried on as it changed last.
//
// While references and measurements go on smoothly, the optimum u*(t) is a smooth path between changes of the active set.
// With the secant of the last two plans the guess is off by O(dt^2) in place of O(dt), and the Newton step by O(dt^4)
// in place of O(dt^2): the predictor and corrector of path following. Multipliers are carried on as well, so that the
// active set is mostly right at once. Where measurements jump, from noise, the plan before is the better guess: inputs vote,
// by how far the step corrects what was foreseen of them.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base/index.hpp"
#include "sightline/base/no_value.hpp"
#include "sightline/solver/newton/newton_update.hpp"

namespace sightline {
namespace {

using L = NativeLane;

}  // namespace

/// Whether the update begins where the plan would go, and how far; group by group it goes there as it is rolled out.
void NewtonUpdate::extrapolate_plan() noexcept {
  const double passed = time_ - plan_time_, before = plan_time_ - plan_before_time_;
  if (!(passed > 0)) return detach_plan();
  std::swap(H_u_, H_before_);
  constexpr double farthest = 2.0;  // of the period before
  foreseen_ = taken_ >= 2 && passed <= farthest * before && is_foreseeable();
  if (!foreseen_) return detach_plan();
  foresight_ = {u_, passed / before};
  if (u_ == plan_) u_ = spare_;
}

bool NewtonUpdate::is_foreseeable() noexcept {
  constexpr double steady = 0.5;  // of a correction, that the next one is at least, unless steps converge
  constexpr int longest_pause = 64;
  if (foreseen_) {
    if (votes_ >= 0) {
      pause_ = 1;
      return true;
    }
    wait_ = pause_;
    pause_ = std::min(2 * pause_, longest_pause);
  }
  if (wait_ > 0) --wait_;
  return wait_ == 0 && corrected_ >= steady * corrected_before_;
}

/// Inputs of a group go on from where they are by `ratio` of their last change. Where they come to a limit it is active; where the
/// multiplier of an active one goes through zero it is not.
void NewtonUpdate::extrapolate_plan(int group) noexcept {
  const auto& [from, ratio] = foresight_;
  const Layout::Span its = groups_.layout().u_of(group);
  const L on(infinity), off(0.0);
  L held = 0.0;
  const std::ptrdiff_t first_end = first_stage_end(group);
  std::ptrdiff_t of = its.first;
  for (std::ptrdiff_t i = its.first; i < its.end(); i += L::width) {
    const std::ptrdiff_t limits = limits_move_ ? i : of;
    const L u = L::load(from + i), low = L::load(low_ + limits), high = L::load(high_ + limits);
    const L next = u + L(ratio) * (u - L::load(plan_before_ + i));
    L to = clamp(next, low, high), active = where_negative(-absolute(next - to), on, off);
    const L was = all_free_ ? off : L::load(active_ + i);
    if (any_negative(-was)) {
      const L H = L::load(H_before_ + i), ahead = H + L(ratio) * (H - L::load(H_u_ + i));
      to = where_negative(-was, u, to);
      active = where_negative(-was, where_negative(-outward(u, low, high, ahead), on, off), active);
    }
    if (any_negative(-was - active)) active.store(active_ + i);
    to.store(u_ + i);
    held = maximum(held, active);
    if ((of += L::width) == first_end) of = its.first;
  }
  held_[at(group)] = largest(held) > 0;
}

/// Keeps u as the plan, and that of the update before, to go on from; whether the next can be foreseen.
void NewtonUpdate::remember(const Step& step) noexcept {
  spare_ = plan_;
  if (time_ > plan_time_) {
    std::swap(spare_, plan_before_);
    plan_before_time_ = plan_time_;
  }
  plan_ = u_;
  plan_time_ = time_;
  taken_ = step.taken ? taken_ + 1 : 0;
  corrected_before_ = std::exchange(corrected_, step.correction);
}

/// u is to change, and the plan to stay.
void NewtonUpdate::detach_plan() noexcept {
  if (u_ != plan_) return;
  u_ = spare_;
  std::copy_n(plan_, groups_.layout().u_length, u_);
}

}  // namespace sightline
