/// The longest time for which a solver gave its robots no plan.
#pragma once

#include "sightline/loop.hpp"

namespace sightline {

/// A sequence of updates without a plan.
struct PlanGap {
  double longest = 0.0;  ///< duration [s]; 0: none
  double from = 0.0;     ///< start [s]
  Status status{};       ///< of the first update
};

/// Evaluates the records of one controller. A gap lasts from the first update without a plan to the
/// next update with one. For failed(), a gap begins at the solver's first own failure. Updates that
/// an injected fault delays, and the time before all bodies were measured, do not count.
class PlanGaps {
 public:
  /// @param period  duration that the record covers [s]
  void add(double time, double period, const SolverRecord& record) noexcept {
    const bool planned = record.answered && gives_plan(record.status);
    follow(any_, open_any_, !planned, planned, time, period, record.status);
    follow(failed_, open_failed_, record.answered && !planned, planned, time, period, record.status);
  }

  /// Longest gap of any cause.
  const PlanGap& any() const noexcept { return any_; }
  /// Longest gap that began with a failed update of the solver.
  const PlanGap& failed() const noexcept { return failed_; }

 private:
  static void follow(PlanGap& longest, PlanGap& open, bool begins, bool ends, double time, double period,
                     Status status) noexcept {
    if (ends) open = {};
    if (begins && open.longest == 0) open = {0.0, time, status};
    if (ends || (!begins && open.longest == 0)) return;
    open.longest = time + period - open.from;
    if (open.longest > longest.longest) longest = open;
  }

  PlanGap any_, failed_, open_any_, open_failed_;
};

}  // namespace sightline
