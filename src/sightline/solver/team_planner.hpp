/// Planning in a team that changes: what a solver is asked for beside updates where robots come and go, or where a team
/// plans in several pieces.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/solver/prediction.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

/// A plan that can be read, set and taken over from the solver of another team, and that is made with what other bodies
/// predict of themselves. A solver that is one says so by Solver::team_planner().
class TeamPlanner {
 public:
  virtual const Ocp& ocp() const = 0;

  /// The inputs planned at stage k, of all agents (nu): what the next update starts from. Here and below a stage or a
  /// length that is not the problem's changes nothing. Neither allocates, locks nor blocks.
  virtual void plan(int k, std::span<double> u) const noexcept = 0;
  /// Puts another plan in its place, limits permitting. All stages must be set.
  virtual void set_plan(int k, std::span<const double> u) noexcept = 0;

  /// Sets the predicted trajectory of a body that is not controlled here, at most N + 1 sights; without it the body is
  /// taken to keep its velocity. It is used for updates within one horizon of its time, until the next one is set; an
  /// empty one ends it. One that is too long, or of a robot that is planned here, is ignored.
  virtual void set_prediction(const Prediction& prediction) noexcept = 0;

  /// Residual up to which an update is `converged` [1/s].
  virtual double tolerance() const noexcept = 0;

  /// The inputs planned at all stages  (N x nu).
  std::vector<double> whole_plan() const;
  /// Goes on from the plan of another team's solver: agents that both have, by name, get their inputs of it, the others
  /// keep what is planned for them here. Allocates. A plan over other stages changes nothing.
  /// @param plan  of the agents of `before`  (N x nu of that team)
  void take_over(const Team& before, std::span<const double> plan);

 protected:
  ~TeamPlanner() = default;
};

/// The capability of a solver that `need` asks for, "a team that changes in flight" say.
/// @throws std::invalid_argument naming the solver and the need where it has none
TeamPlanner& team_planner_of(Solver& solver, std::string_view need);

/// Makes the solver of a team, over one horizon and with options of its own. May throw what a solver's making throws.
using MakeSolver = std::function<std::unique_ptr<Solver>(Team)>;

}  // namespace sightline
