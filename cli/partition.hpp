/// A flight whose team plans in subteams, `--partition`: its solver and the evaluation after the
/// flight.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/scenario.hpp"
#include "sightline/solvers.hpp"

namespace sightline::cli {

/// The partition of a command line, read and checked.
struct PartitionChoice {
  std::string text{};  ///< text as given; empty: from the scenario
  Partition parts{};
  ExchangeOrder order = ExchangeOrder::gauss_seidel;
  int exchanges = 1;
  std::optional<ExchangeOptions> messages{};  ///< from the scenario's [partition]
  int threads = 1;

  PartitionOptions options() const { return {order, exchanges, messages, threads}; }
};

/// The partition of a scenario; none if one solver plans the whole team or its part.
std::optional<PartitionChoice> partition_of(const Scenario& scenario, int threads = 1);

/// @throws std::invalid_argument with a message if the text does not fit the scenario
PartitionChoice read_partition(const Scenario& scenario, const std::string& parts, const std::string& order,
                               int exchanges, int threads = 1);

/// A solver that returns the commands of its partitioned solver and samples moments of the flight,
/// evenly spread, for later evaluation. It allocates before the flight.
class PartitionedFlight final : public Solver {
 public:
  PartitionedFlight(const Scenario& scenario, const PartitionChoice& choice);

  std::string_view name() const override { return solver_.name(); }
  const Ocp& ocp() const override { return solver_.ocp(); }
  Solution solve(double time, std::span<const double> states) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override {
    return solver_.kkt(time, states);
  }
  void planned(double time, std::span<double> u) const noexcept override { solver_.planned(time, u); }
  void restart() noexcept override { solver_.restart(); }
  void set_applied(const AppliedInputs& applied) noexcept override { solver_.set_applied(applied); }
  const Connectivity* connectivity() const noexcept override { return solver_.connectivity(); }
  bool keeps_apart() const noexcept override { return solver_.keeps_apart(); }

  /// Evaluates, after the flight, the distance of the exchanges from the optimum of the whole team
  /// at the sampled moments. Writes partition.json into the folder.
  /// @param summary, whole  summary.json of this flight, and of the same flight with a solver of
  ///   the whole team
  /// @return a table as text
  std::string print_message(const std::filesystem::path& folder, const std::string& summary,
                            const std::string& whole);

 private:
  struct PartSample {
    double time;
    std::vector<double> states, plan;  // before the update
  };

  PartitionChoice choice_;
  SolverChoice subteam_solver_;  // with its default options
  PartitionedSolver solver_;
  std::vector<PartSample> moments_;
  std::vector<double> part_us_;               // of each update, the slowest subteam
  std::vector<std::vector<double>> each_us_;  // of each subteam, its updates
  std::size_t kept_ = 0, updates_ = 0, stride_ = 1;
};

}  // namespace sightline::cli
