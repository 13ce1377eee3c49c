/// A subteam: robots of a team that plan by themselves; the others they are coupled with fly as they predict.
///
///   min over u_S   sum over i in S of l_i + sum of the couplings that a robot of S feels,  others' sights given
///
/// A coupling felt by robots of two subteams stands in both, one end each: given the others' trajectories the derivative
/// by the own inputs is that of the whole team, so what no subteam can better is a stationary point of the whole.
/// Subteams share no memory: what one sends and another receives are `Prediction`s. docs/partition.md
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/solver/team_planner.hpp"

namespace sightline {

/// Which bodies outside a subteam knows.
enum class Others : std::uint8_t { felt, all };

/// The robots of `own` with all that they feel; bodies outside, those that they are coupled with or all, become obstacles of
/// their names. Robots come first, both in the order of the whole team.
/// @throws std::invalid_argument for an empty list, a body that is no robot, or a swarm of which others are too
Team subteam_of(const Team& whole, std::span<const AgentId> own, Others others = Others::felt);

class Subteam {
 public:
  /// @throws std::invalid_argument as subteam_of does, what making the solver throws, and where that is no TeamPlanner
  Subteam(const Team& whole, std::span<const AgentId> own, const MakeSolver& make,
          Others others = Others::felt);

  const Ocp& ocp() const { return solver_->ocp(); }
  const Solver& solver() const { return *solver_; }
  /// Of a body of the subteam's team: its id in the whole team. @throws std::out_of_range
  BodyId in_whole(BodyId body) const { return in_whole_.at(at(body)); }

  /// One update; `states` are those of all bodies of the whole team, of which the subteam reads what it knows. The
  /// solution is in the order of the subteam's own team. As a solver's, it neither throws nor allocates.
  Solution solve(double time, std::span<const double> states) noexcept;

  /// As Solver::set_applied(), in the order of the subteam's own team.
  void set_applied(const AppliedInputs& applied) noexcept { solver_->set_applied(applied); }

  /// Where the own robots will be under the present plan, one message each, `who` of the whole team.
  std::span<const Prediction> predictions() const { return predictions_; }
  /// Takes a message; of a robot that nobody here is coupled with, or not finite, it is ignored.
  void receive(const Prediction& prediction) noexcept { receive(prediction, prediction.time); }
  /// The same, where its first sight is at another time of ours: clocks differ.
  void receive(const Prediction& prediction, double time) noexcept;
  /// Ends what was received of a body of the whole team.
  void forget(BodyId who) noexcept;
  /// The same, but for an empty one: that ends what was received before.
  void set_prediction(const Prediction& prediction) noexcept;

  /// Of the own robots' conditions at the present plan, given what was received.
  double kkt(double time, std::span<const double> states) noexcept;
  void planned(double time, std::span<double> u) const noexcept { solver_->planned(time, u); }
  void plan(int k, std::span<double> u) const noexcept { planner_->plan(k, u); }
  void set_plan(int k, std::span<const double> u) noexcept {
    planned_ = true;
    planner_->set_plan(k, u);
  }
  /// Predicts anew from these states under the present plan, without an update.
  void predict(double time, std::span<const double> states) noexcept;
  void restart() noexcept;

 private:
  int place_of(BodyId who) const noexcept;
  void put(const Prediction& prediction, double time) noexcept;
  void gather(std::span<const double> states) noexcept;
  void roll_out(double time) noexcept;

  const Team whole_;
  std::vector<BodyId> in_whole_;  // of each body
  std::vector<int> in_subteam_;   // of each body of the whole team, or -1
  std::unique_ptr<Solver> solver_;
  TeamPlanner* planner_ = nullptr;  // of the solver
  bool planned_ = false;
  std::vector<double> x_, u_, rate_, path_, no_input_;
  std::vector<Prediction> predictions_;
  Prediction received_;  // with the id that the subteam knows
};

}  // namespace sightline
