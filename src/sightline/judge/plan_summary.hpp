/// Time during which the solvers of a flight gave no plan.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sightline/run/plan_gap.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

class PlanSummary {
 public:
  /// @param controllers  number of solver records in each sample
  PlanSummary(const Scenario& scenario, std::size_t controllers);

  void add(const Sample& sample);

  /// Longest gap of any solver, for any reason.
  PlanGap longest() const;
  /// One sentence for each solver that ran but gave no plan for longer than hold_after.
  std::vector<std::string> failures() const;
  /// Object "without_plan" of summary.json.
  std::string json() const;

 private:
  double period_, hold_after_;  // [s]
  std::vector<PlanGaps> gaps_;  // of each solver
};

/// Describes that object for people; empty if there always was a plan.
std::string describe_without_plan(std::string_view json);

}  // namespace sightline
