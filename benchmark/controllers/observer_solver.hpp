/// Controllers of observers as solvers of a team: they plan the observers, and NewtonRiccati the other robots.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "benchmark/controllers/view_task.hpp"
#include "sightline/solvers.hpp"

namespace sightline::benchmark {

/// Controller of the observers of a team. As of a Solver: calls do not throw, allocate or lock, unless its class
/// states otherwise.
class ObserverControl {
 public:
  virtual ~ObserverControl() = default;
  /// Writes the inputs of its observers at time [s], given the states of all bodies (nx), into the inputs of all
  /// robots (nu). The caller clamps them. `u` holds the inputs of the last update.
  virtual Status inputs(double time, std::span<const double> states, std::span<double> u) noexcept = 0;
  /// Discards what it remembers of the flight.
  virtual void restart() noexcept = 0;
};

/// Law of one observer.
class ViewLaw {
 public:
  virtual ~ViewLaw() = default;
  /// @param x       state of the robot (7)
  /// @param bodies  the target, then the others of its task
  /// @param u       its inputs (4)
  virtual Status inputs(const double* x, std::span<const Sight<double>> bodies,
                        std::span<double> u) noexcept = 0;
  virtual void restart() noexcept {}
};

/// One law for each observer.
class SeparateLaws final : public ObserverControl {
 public:
  /// @param laws  of the tasks, in their order
  SeparateLaws(const Team& team, std::vector<ViewTask> tasks, std::vector<std::unique_ptr<ViewLaw>> laws);
  Status inputs(double time, std::span<const double> states, std::span<double> u) noexcept override;
  void restart() noexcept override;

 private:
  Team team_;
  std::vector<ViewTask> tasks_;
  std::vector<std::unique_ptr<ViewLaw>> laws_;
  std::vector<double> resting_;
  std::vector<Sight<double>> bodies_;
};

class ObserverSolver final : public Solver {
 public:
  /// @throws std::invalid_argument as view_tasks()
  ObserverSolver(std::string name, const Team& team, const Horizon& horizon,
                 const std::vector<ViewTask>& tasks, std::unique_ptr<ObserverControl> control);

  std::string_view name() const override { return name_; }
  const Ocp& ocp() const override { return ocp_; }
  Solution solve(double time, std::span<const double> states) noexcept override;
  void set_applied(const AppliedInputs& applied) noexcept override;
  double kkt(double, std::span<const double>) noexcept override { return infinity; }
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  KernelUse kernels() const override { return rest_.kernels(); }

 private:
  /// Applies a function to the range of each observer's inputs: (agent, first input, number of inputs).
  template <class Each>
  void each_observer(Each each) const noexcept;

  std::string name_;
  Ocp ocp_;
  NewtonRiccati rest_;
  std::vector<AgentId> observers_;
  std::unique_ptr<ObserverControl> control_;
  std::vector<double> u_, raw_u_, wanted_, offset_, u_min_, u_max_;
};

}  // namespace sightline::benchmark
