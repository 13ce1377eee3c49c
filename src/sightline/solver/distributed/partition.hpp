/// A team whose subteams plan by themselves and send each other where they will be: one solver outside, several within.
///
/// An update is one exchange or more. In each, every subteam solves once, given the trajectories it received last, and sends
/// its own: in Jacobi order when all have solved, so that they could work at one time; in Gauss-Seidel order at once,
/// so that those after it know. Trajectories of the last update are carried on to the present one. Or each sends once, and the
/// message comes as the network lets it. docs/partition.md
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/thread_pool.hpp"
#include "sightline/solver/distributed/peers.hpp"
#include "sightline/solver/distributed/simulated_messages.hpp"
#include "sightline/solver/distributed/subteam.hpp"

namespace sightline {

enum class ExchangeOrder : std::uint8_t { jacobi, gauss_seidel };

std::string_view to_string(ExchangeOrder order);
/// @throws std::invalid_argument for a word that is none
ExchangeOrder exchange_order(std::string_view word);

/// Every robot of a team in exactly one subteam.
using Partition = std::vector<std::vector<AgentId>>;

/// A subteam as a text names it.
struct PartInWords {
  std::string name;  ///< empty: none is given
  std::vector<std::string> robots;
};
/// Takes "front: a,b | c,d" apart; whether there are such robots nobody asks.
/// @throws std::invalid_argument for a name that two have
std::vector<PartInWords> parts_in_words(std::string_view text);

/// Reads "a,b | c,d": robots by name, subteams in the order in which they solve; a subteam may have a name, "front: a,b".
/// @throws std::invalid_argument with a sentence for a name that is no robot, a robot named twice or in no subteam, and a
/// subteam without robots
Partition read_partition(std::string_view text, const Team& team);

struct PartitionOptions {
  ExchangeOrder order = ExchangeOrder::gauss_seidel;
  int exchanges = 1;  ///< an update, 1..1000
  /// Messages that take time and get lost, as between computers: then one exchange an update, in Jacobi order. None: what is sent
  /// is there at once.
  std::optional<ExchangeOptions> messages{};
  /// That solve subteams at the same time in Jacobi order, 1..ThreadPool::most; the plan is the same whatever their number.
  int threads = 1;
};

/// @throws std::invalid_argument for an option out of its range, or options that do not go together
void check_options(const PartitionOptions& options);

class PartitionedSolver : public Solver, public TeamPlanner, public Connectivity {
 public:
  /// @param make  the solver of each subteam, and that of the whole team, which judges the plan of all
  /// @throws std::invalid_argument for an option out of its range, where a robot is not in exactly one subteam, or where
  /// what is made is no TeamPlanner; and what making a solver throws
  PartitionedSolver(const Team& team, const Partition& partition, const MakeSolver& make,
                    const PartitionOptions& options = {});

  std::string_view name() const override { return "partitioned"; }
  const Ocp& ocp() const override { return whole_->ocp(); }
  /// The residual is that of the whole team's conditions at the new plan; it is found after the subteams have ended, and
  /// not in `elapsed`, which is all of them in turn.
  Solution solve(double time, std::span<const double> states) noexcept override;
  void set_applied(const AppliedInputs& applied) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  TeamPlanner* team_planner() noexcept override { return this; }
  const Connectivity* connectivity() const noexcept override { return messages_ ? this : nullptr; }
  bool keeps_apart() const noexcept override { return whole_->keeps_apart(); }

  void plan(int k, std::span<double> u) const noexcept override;
  /// What subteams received stays until others send again.
  void set_plan(int k, std::span<const double> u) noexcept override;
  void set_prediction(const Prediction& prediction) noexcept override;
  double tolerance() const noexcept override { return whole_planner_->tolerance(); }
  /// Lets every subteam send where its plan leads from these states.
  void send_all(double time, std::span<const double> states) noexcept;

  bool receives_from(BodyId robot, BodyId other) const noexcept override;
  bool is_received(BodyId body) const noexcept override;

  int subteams() const { return static_cast<int>(members_.size()); }
  /// Processor time of the last update's slowest subteam, all its exchanges [s]: what subteams on machines of their own would take.
  double slowest() const noexcept;
  /// Of one subteam [s].
  double elapsed(int subteam) const noexcept { return members_[static_cast<std::size_t>(subteam)].elapsed; }

 private:
  struct Member {
    std::unique_ptr<Subteam> subteam;
    mutable std::vector<double> u;      // scratch, in the subteam's order
    std::vector<double> before, u_ref;  // the same
    std::vector<Vec2<double>> lean;     // the same, of each body
    double elapsed = 0.0;               // processor time of the last update [s]
    Solution solution = {};             // of the last exchange
  };

  /// Part of a robot; -1: of none.
  int part_of(BodyId body) const noexcept { return part_of_[static_cast<std::size_t>(body.index)]; }
  void talk_before(double time, std::span<const double> states) noexcept;
  void receive(int to, double time) noexcept;
  bool accepts(double time, std::span<const double> states) noexcept;
  void exchange(double time, std::span<const double> states) noexcept;
  void send(const Member& sender) noexcept;
  /// Does something for each subteam, at the same time on all threads.
  template <class Of>
  void for_each(Of&& of) noexcept;
  /// Does something for a subteam, and counts the time.
  template <class Of>
  void timed(int subteam, Of&& of) noexcept;
  void gather(const Subteam& subteam, std::span<const double> of_whole,
              std::span<double> of_subteam) const noexcept;
  void scatter(const Subteam& subteam, std::span<const double> of_subteam,
               std::span<double> of_whole) const noexcept;
  void write_states(std::span<const double> states) noexcept;

  std::unique_ptr<Solver> whole_;  // holds the plan of all, to judge it
  TeamPlanner* whole_planner_;     // of it
  bool has_plan_ = false;
  PartitionOptions options_;
  std::vector<Member> members_;
  std::vector<int> part_of_;                   // of each body
  std::optional<SimulatedMessages> messages_;  // none: what is sent is there at once
  std::vector<double> x_now_, u_, raw_u_, u_stage_, x_;
  ThreadPool pool_;
};

}  // namespace sightline
