/// A subteam: robots of a team that plan separately; coupled bodies outside follow their
/// predictions.
///
///   min over u_S   sum over i in S of l_i + sum of the couplings that act on a robot of S
///
/// with the Sights of the other bodies given. A coupling that acts on robots of two subteams
/// belongs to both, one end each. Given the other trajectories, its derivative by the own inputs is
/// that of the whole team. A plan that no subteam can improve is thus a stationary point of the
/// whole. Subteams share no memory; they exchange `Prediction`s. docs/partition.md
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/solver/team_planner.hpp"

namespace sightline {

/// Which bodies outside are part of a subteam's problem.
enum class Others : std::uint8_t { felt, all };

/// Team of the robots in `own` with all couplings that act on them. Bodies outside, the coupled
/// ones or all, become obstacles with the same names. Robots come first, both in the order of the
/// whole team.
/// @throws std::invalid_argument for an empty list, a body that is no robot, or a swarm with robots
///   outside
Team subteam_of(const Team& whole, std::span<const AgentId> own, Others others = Others::felt);

class Subteam {
 public:
  /// @throws std::invalid_argument as subteam_of does, and if the solver is no TeamPlanner; and
  ///   what making the solver throws
  Subteam(const Team& whole, std::span<const AgentId> own, const MakeSolver& make,
          Others others = Others::felt);

  const Ocp& ocp() const { return solver_->ocp(); }
  const Solver& solver() const { return *solver_; }
  /// Id in the whole team of a body of the subteam. @throws std::out_of_range
  BodyId in_whole(BodyId body) const { return in_whole_.at(at(body)); }

  /// One update; `states` are those of all bodies of the whole team, of which the subteam uses its
  /// own bodies. The solution is in the order of the subteam. Neither throws nor allocates.
  Solution solve(double time, std::span<const double> states) noexcept;

  /// As Solver::set_applied(), in the order of the subteam.
  void set_applied(const AppliedInputs& applied) noexcept { solver_->set_applied(applied); }

  /// Predictions of the own robots under the present plan; `who` refers to the whole team.
  std::span<const Prediction> predictions() const { return predictions_; }
  /// Stores a message; ignores it if the body is unknown here, planned here, or the values are not
  /// finite.
  void receive(const Prediction& prediction) noexcept { receive(prediction, prediction.time); }
  /// As above, with the time of its first Sight by the own clock.
  void receive(const Prediction& prediction, double time) noexcept;
  /// Removes the prediction of a body of the whole team.
  void forget(BodyId who) noexcept;
  /// As receive(prediction), but an empty prediction with h > 0 removes the previous one.
  void set_prediction(const Prediction& prediction) noexcept;

  /// KKT norm of the own robots at the present plan, given the received predictions.
  double kkt(double time, std::span<const double> states) noexcept;
  void planned(double time, std::span<double> u) const noexcept { solver_->planned(time, u); }
  void plan(int k, std::span<double> u) const noexcept { planner_->plan(k, u); }
  void set_plan(int k, std::span<const double> u) noexcept {
    planned_ = true;
    planner_->set_plan(k, u);
  }
  /// Predicts from these states under the present plan, without an update.
  void predict(double time, std::span<const double> states) noexcept;
  void restart() noexcept;

 private:
  int place_of(BodyId who) const noexcept;
  void put(const Prediction& prediction, double time) noexcept;
  void gather(std::span<const double> states) noexcept;
  void roll_out(double time) noexcept;

  const Team whole_;
  std::vector<BodyId> in_whole_;  // per body
  std::vector<int> in_subteam_;   // per body of the whole team; -1: not part of the subteam
  std::unique_ptr<Solver> solver_;
  TeamPlanner* planner_ = nullptr;  // planner of solver_
  bool planned_ = false;
  std::vector<double> x_, u_, rate_, path_, no_input_;
  std::vector<Prediction> predictions_;
  Prediction received_;  // with the subteam's id
};

}  // namespace sightline
