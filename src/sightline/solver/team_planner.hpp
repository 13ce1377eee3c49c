/// Interface for planning in a team that changes in flight, or that plans in several subteams.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/solver/prediction.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

/// A plan that can be read, set and taken over from the solver of another team, and that uses
/// predictions of uncontrolled bodies. Obtained from Solver::team_planner().
class TeamPlanner {
 public:
  virtual const Ocp& ocp() const = 0;

  /// Reads the planned inputs at stage k of all agents (nu): the start of the next update. In
  /// plan() and set_plan() an invalid stage or length has no effect. Neither allocates, locks nor
  /// blocks.
  virtual void plan(int k, std::span<double> u) const noexcept = 0;
  /// Replaces the plan at stage k; the next update clamps it to the limits. All stages must be set.
  virtual void set_plan(int k, std::span<const double> u) noexcept = 0;

  /// Sets the predicted trajectory of an uncontrolled body, at most N + 1 Sights; without it the
  /// body keeps its velocity. Updates within one horizon of its time use it, until the next
  /// prediction is set; an empty one removes it. Ignores a prediction that is too long or of a
  /// robot planned here.
  virtual void set_prediction(const Prediction& prediction) noexcept = 0;

  /// Residual up to which an update is `converged` [1/s].
  virtual double tolerance() const noexcept = 0;

  /// Planned inputs at all stages  (N x nu).
  std::vector<double> whole_plan() const;
  /// Continues the plan of another team's solver: agents of both teams, matched by name, take their
  /// inputs from that plan; the others keep theirs. Allocates. No effect if the plan has other
  /// stages.
  /// @param plan  inputs of the agents of `before`  (N x nu of that team)
  void take_over(const Team& before, std::span<const double> plan);

 protected:
  ~TeamPlanner() = default;
};

/// The TeamPlanner of a solver.
/// @param need  the feature that requires it, such as "a team that changes in flight"
/// @throws std::invalid_argument naming the solver and the need if it is no TeamPlanner
TeamPlanner& team_planner_of(Solver& solver, std::string_view need);

/// Makes the solver of a team, with a fixed horizon and fixed options. May throw what the
/// constructor of the solver throws.
using MakeSolver = std::function<std::unique_ptr<Solver>(Team)>;

}  // namespace sightline
