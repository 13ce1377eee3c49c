/// A team whose parts plan by themselves and tell each other where they will be: one solver to look at, several within.
///
/// An update is `exchanges` rounds. In each every part solves once, given the trajectories it was told last, and tells
/// its own: in Jacobi order when all have solved, so that they could work at one time; in Gauss-Seidel order at once,
/// so that those after it know. Trajectories of the last update are carried on to the present one. docs/partition.md
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "sightline/solver/distributed/part.hpp"

namespace sightline {

enum class ExchangeOrder : std::uint8_t { jacobi, gauss_seidel };

std::string_view to_string(ExchangeOrder order);
/// @throws std::invalid_argument for a word that is none
ExchangeOrder exchange_order(std::string_view word);

/// Every robot of a team in exactly one part.
using Partition = std::vector<std::vector<AgentId>>;

/// Reads "a,b | c,d": robots by name, parts in the order in which they solve.
/// @throws std::invalid_argument with a sentence for a name that is no robot, a robot named twice or in no part, and a
/// part without robots
Partition read_partition(std::string_view text, const Team& team);

struct PartitionOptions {
  ExchangeOrder order = ExchangeOrder::gauss_seidel;
  int exchanges = 1;  ///< rounds an update, 1..1000
};

class PartitionedSolver : public Solver, public TeamPlanner {
 public:
  /// @param make  the solver of each part, and that of the whole team, which judges the plan of all
  /// @throws std::invalid_argument for an option out of its range, where a robot is not in exactly one part, or where
  /// what is made is no TeamPlanner; and what making a solver throws
  PartitionedSolver(const Team& team, const Partition& partition, const MakeSolver& make,
                    const PartitionOptions& options = {});

  std::string_view name() const override { return "partitioned"; }
  const Ocp& ocp() const override { return whole_->ocp(); }
  /// The residual is that of the whole team's conditions at the new plan; it is found after the parts have ended, and
  /// not in `elapsed`, which is all of them in turn.
  Solution solve(double time, std::span<const double> states) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  TeamPlanner* team_planner() noexcept override { return this; }
  bool keeps_apart() const noexcept override { return whole_->keeps_apart(); }

  void plan(int k, std::span<double> u) const noexcept override;
  /// What parts were told stays until they tell again.
  void set_plan(int k, std::span<const double> u) noexcept override;
  void set_prediction(const Prediction& prediction) noexcept override;
  double tolerance() const noexcept override { return whole_planner_->tolerance(); }
  /// Lets every part tell where its plan leads from these states, and the others hear it.
  void tell_all(double time, std::span<const double> states) noexcept;

  int parts() const { return static_cast<int>(members_.size()); }
  /// Wall time of the last update's slowest part, all its rounds [s]: what parts on machines of their own would take.
  double slowest() const noexcept;

 private:
  struct Member {
    std::unique_ptr<Part> part;
    mutable std::vector<double> u;  // scratch, in the part's order
    double elapsed = 0.0;           // of the last update [s]
    Solution solution = {};         // of the last round
  };

  bool accepts(double time, std::span<const double> states) noexcept;
  void round(double time, std::span<const double> states) noexcept;
  void tell(const Member& teller) noexcept;
  void scatter(const Part& part, std::span<const double> of_part, std::span<double> of_whole) const noexcept;
  void write_states(std::span<const double> states) noexcept;

  std::unique_ptr<Solver> whole_;  // holds the plan of all, to judge it
  TeamPlanner* whole_planner_;     // of it
  bool has_plan_ = false;
  PartitionOptions options_;
  std::vector<Member> members_;
  std::vector<double> x_now_, u_, raw_u_, u_stage_, x_;
};

}  // namespace sightline
