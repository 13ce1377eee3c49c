/// Stage "solve": from the controllers to inputs and predicted paths. If a command is not finite or
/// not within the solver's limits, the last good one stays.
#pragma once

#include "sightline/loop.hpp"
#include "sightline/run/controller.hpp"
#include "sightline/run/stages/period.hpp"
#include "sightline/run/warm_up.hpp"

namespace sightline::stages {

class Solve {
 public:
  /// The options must outlive the object.
  /// @throws std::invalid_argument unless each robot of the world is steered by exactly one
  ///         controller, with the loop's period, and for a fault out of its range
  Solve(const World& world, const Controllers& controllers, const LoopOptions& options, const Period& period);

  void run(Period& period) noexcept;
  /// Between two periods: brings the solvers into the caches before period k.
  void warm_up(Clock& clock, std::int64_t k) noexcept;

 private:
  void check_steered(const std::vector<Presence>& presence) const;
  std::span<Controller> controllers() noexcept;
  bool knows_all() const noexcept;
  void request(Controller& controller, const Period& period) noexcept;
  Solution solve(Controller& controller, const Period& period) noexcept;
  void command(int index, const Controller& controller, const Solution& solution, Period& period) noexcept;
  void begin_path(const Period& period) const noexcept;
  void write_path(const Controller& controller, const Solution& solution, const Period& period) noexcept;

  const Team& team_;  // of the world
  const LoopOptions& options_;
  std::vector<Controller> controllers_;  // if the team does not change
  WarmUp warm_up_;
  bool use_applied_;                   // solvers receive the applied inputs
  std::vector<double> u_min_, u_max_;  // of one robot
  std::vector<double> plan_;           // inputs of one stage of a plan
};

}  // namespace sightline::stages
