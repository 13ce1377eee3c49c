/// The time in which the solvers of a flight gave no plan.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sightline/run/plan_gap.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

class PlanSummary {
 public:
  /// @param controllers  solver records in each sample
  PlanSummary(const Scenario& scenario, std::size_t controllers);

  void add(const Sample& sample);

  /// Of any solver, whatever the reason.
  PlanGap longest() const;
  /// A sentence for each solver that was asked and gave no plan for longer than hold_after.
  std::vector<std::string> failures() const;
  /// The object "without_plan" of summary.json.
  std::string json() const;

 private:
  double period_, hold_after_;  // [s]
  std::vector<PlanGaps> gaps_;  // of each solver
};

/// That object for a person; empty where there was always a plan.
std::string without_plan_in_words(std::string_view json);

}  // namespace sightline
