/// Solver of a team in subteams that plan separately and exchange predictions: one solver outside,
/// several inside.
///
/// An update consists of one or more exchanges. In each, every subteam solves once with the latest
/// received trajectories, and sends its own. Jacobi order: all send after all have solved, so they
/// can run in parallel. Gauss-Seidel order: each sends immediately, so later subteams use it.
/// Trajectories of the last update are extrapolated to the present. With simulated messages each
/// subteam sends once per update, and the network delays or drops the message. docs/partition.md
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
/// @throws std::invalid_argument for an unknown word
ExchangeOrder exchange_order(std::string_view word);

/// Partition: every robot of a team in exactly one subteam.
using Partition = std::vector<std::vector<AgentId>>;

/// A subteam in text form.
struct PartInWords {
  std::string name;  ///< empty: no name
  std::vector<std::string> robots;
};
/// Splits "front: a,b | c,d"; does not check that the robots exist.
/// @throws std::invalid_argument for a repeated name
std::vector<PartInWords> parts_in_words(std::string_view text);

/// Reads "a,b | c,d": robots by name, subteams in solving order; a subteam may have a name, "front:
/// a,b".
/// @throws std::invalid_argument naming an unknown robot, a robot named twice or in no subteam, or
///   a subteam without robots
Partition read_partition(std::string_view text, const Team& team);

struct PartitionOptions {
  ExchangeOrder order = ExchangeOrder::gauss_seidel;
  int exchanges = 1;  ///< per update, 1..1000
  /// Messages with delay and loss, as between computers; then one exchange per update, in Jacobi
  /// order. None: predictions arrive immediately.
  std::optional<ExchangeOptions> messages{};
  /// Threads that solve subteams in parallel in Jacobi order, 1..ThreadPool::most; the plan is
  /// independent of their number.
  int threads = 1;
};

/// @throws std::invalid_argument for an option out of its range, or an invalid combination of
///   options
void check_options(const PartitionOptions& options);

class PartitionedSolver : public Solver, public TeamPlanner, public Connectivity {
 public:
  /// @param make  makes the solver of each subteam, and that of the whole team, which evaluates the
  ///   whole plan
  /// @throws std::invalid_argument for an option out of its range, if a robot is not in exactly one
  ///   subteam, or if a solver is no TeamPlanner; and what making a solver throws
  PartitionedSolver(const Team& team, const Partition& partition, const MakeSolver& make,
                    const PartitionOptions& options = {});

  std::string_view name() const override { return "partitioned"; }
  const Ocp& ocp() const override { return whole_->ocp(); }
  /// The residual is that of the whole team's conditions at the new plan. It is computed after the
  /// subteams have finished; `elapsed`, the wall time of all subteams, excludes it.
  Solution solve(double time, std::span<const double> states) noexcept override;
  void set_applied(const AppliedInputs& applied) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  TeamPlanner* team_planner() noexcept override { return this; }
  const Connectivity* connectivity() const noexcept override { return messages_ ? this : nullptr; }
  bool keeps_apart() const noexcept override { return whole_->keeps_apart(); }

  void plan(int k, std::span<double> u) const noexcept override;
  /// Predictions that subteams received stay in force until the next ones arrive.
  void set_plan(int k, std::span<const double> u) noexcept override;
  void set_prediction(const Prediction& prediction) noexcept override;
  double tolerance() const noexcept override { return whole_planner_->tolerance(); }
  /// Makes every subteam send the prediction of its plan from these states.
  void send_all(double time, std::span<const double> states) noexcept;

  bool receives_from(BodyId robot, BodyId other) const noexcept override;
  bool is_received(BodyId body) const noexcept override;

  int subteams() const { return static_cast<int>(members_.size()); }
  /// Processor time of the slowest subteam in the last update, all exchanges [s]: the update time
  /// with one computer per subteam.
  double slowest() const noexcept;
  /// Processor time of one subteam [s].
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

  /// Index of a robot's part; -1: none.
  int part_of(BodyId body) const noexcept { return part_of_[static_cast<std::size_t>(body.index)]; }
  void talk_before(double time, std::span<const double> states) noexcept;
  void receive(int to, double time) noexcept;
  bool accepts(double time, std::span<const double> states) noexcept;
  void exchange(double time, std::span<const double> states) noexcept;
  void send(const Member& sender) noexcept;
  /// Calls of(subteam) for each subteam, in parallel on the thread pool.
  template <class Of>
  void for_each(Of&& of) noexcept;
  /// Calls of(subteam) and measures its processor time.
  template <class Of>
  void timed(int subteam, Of&& of) noexcept;
  void gather(const Subteam& subteam, std::span<const double> of_whole,
              std::span<double> of_subteam) const noexcept;
  void scatter(const Subteam& subteam, std::span<const double> of_subteam,
               std::span<double> of_whole) const noexcept;
  void write_states(std::span<const double> states) noexcept;

  std::unique_ptr<Solver> whole_;  // evaluates the whole plan
  TeamPlanner* whole_planner_;     // planner of whole_
  bool has_plan_ = false;
  PartitionOptions options_;
  std::vector<Member> members_;
  std::vector<int> part_of_;                   // per body
  std::optional<SimulatedMessages> messages_;  // none: predictions arrive immediately
  std::vector<double> x_now_, u_, raw_u_, u_stage_, x_;
  ThreadPool pool_;
};

}  // namespace sightline
