/// For how long a solver left its robots without a plan.
#pragma once

#include "sightline/run/sample.hpp"

namespace sightline {

/// A stretch of updates without a plan.
struct PlanGap {
  double longest = 0.0;  ///< [s]; 0: there was none
  double from = 0.0;     ///< its begin [s]
  Status status{};       ///< of its first update
};

/// Follows the records of one controller. The time in which the last plan was used counts from the first update
/// without a plan to the next with one. The solver's own failures count from its first one: an update that is late
/// by an injected fault, and the time before all bodies were measured, are not among them.
class PlanGaps {
 public:
  /// @param period  that the record stands for [s]
  void add(double time, double period, const SolverRecord& record) noexcept {
    const bool planned = record.answered && gives_plan(record.status);
    follow(any_, open_any_, !planned, planned, time, period, record.status);
    follow(failed_, open_failed_, record.answered && !planned, planned, time, period, record.status);
  }

  /// Whatever the reason.
  const PlanGap& any() const noexcept { return any_; }
  /// From an update that the solver was asked for and failed.
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
