/// A part of a team that plans by itself: its own robots are steered, the others it couples with fly as they tell.
///
///   min over u_P   sum over i in P of l_i + sum of the couplings that a robot of P feels,  others' sights given
///
/// A coupling felt by robots of two parts stands in both, one end each: given the others' trajectories the derivative
/// by the own inputs is that of the whole team, so what no part can better is a stationary point of the whole.
/// Parts share no memory: what one tells and another hears are `Prediction`s. docs/partition.md
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/solver/team_planner.hpp"

namespace sightline {

/// The robots of `own` with all that they feel; bodies outside that they are coupled with become obstacles of their
/// names. Robots come first, both in the order of the whole team.
/// @throws std::invalid_argument for an empty list, a body that is no robot, or a swarm of which others are too
Team part_of(const Team& whole, std::span<const AgentId> own);

class Part {
 public:
  /// @throws std::invalid_argument as part_of does, what making the solver throws, and where that is no TeamPlanner
  Part(const Team& whole, std::span<const AgentId> own, const MakeSolver& make);

  const Ocp& ocp() const { return solver_->ocp(); }
  /// Of a body of the part's team: its id in the whole team. @throws std::out_of_range
  BodyId in_whole(BodyId body) const { return in_whole_.at(static_cast<std::size_t>(body.index)); }

  /// One update; `states` are those of all bodies of the whole team, of which the part reads what it knows. The
  /// solution is in the order of the part's own team. As a solver's, it neither throws nor allocates.
  Solution solve(double time, std::span<const double> states) noexcept;

  /// Where the own robots will be under the present plan, one message each, `who` of the whole team.
  std::span<const Prediction> told() const { return told_; }
  /// Takes a message in; of a robot that nobody here is coupled with, or not finite, it is left.
  void hear(const Prediction& told) noexcept;
  /// The same, but for an empty one: that ends what was heard before.
  void set_prediction(const Prediction& told) noexcept;

  /// Of the own robots' conditions at the present plan, given what was told.
  double kkt(double time, std::span<const double> states) noexcept;
  void planned(double time, std::span<double> u) const noexcept { solver_->planned(time, u); }
  void plan(int k, std::span<double> u) const noexcept { planner_->plan(k, u); }
  void set_plan(int k, std::span<const double> u) noexcept { planner_->set_plan(k, u); }
  /// Tells anew from these states under the present plan, without an update.
  void look_ahead(double time, std::span<const double> states) noexcept;
  void restart() noexcept;

 private:
  void gather(std::span<const double> states) noexcept;
  void roll_out(double time) noexcept;

  const Team whole_;
  std::vector<BodyId> in_whole_;  // of each body
  std::vector<int> in_part_;      // of each body of the whole team, or -1
  std::unique_ptr<Solver> solver_;
  TeamPlanner* planner_ = nullptr;  // of the solver
  std::vector<double> x_, u_, rate_, path_, no_input_;
  std::vector<Prediction> told_;
  Prediction heard_;  // with the id that the part knows
};

}  // namespace sightline
