/// Stage "change the team": the loop's end of the TeamSwitcher.
#pragma once

#include "sightline/run/stages/period.hpp"

namespace sightline::stages {

class TeamChange {
 public:
  /// The options must outlive the object.
  /// @throws std::invalid_argument unless the present solver of the team switcher is the only
  ///         controller
  TeamChange(World& world, const Controllers& controllers, const Clock& clock, const LoopOptions& options,
             Period& period);

  /// Sends signals, and applies a change that was requested a period ago.
  void run(Period& period) noexcept;
  /// Updates plan times, compensation and guard for a new team, once the world is measured.
  void join(Period& period) noexcept;
  /// Evaluates the triggers of events.
  void look(Period& period) noexcept;

 private:
  bool changes(Period& period) noexcept;
  void follow(Period& period) noexcept;
  void on_join(BodyId body, std::span<const double> x, Period& period) const noexcept;

  World& world_;
  const Clock& clock_;
  const LoopOptions& options_;
  std::vector<Presence> before_;  // of the world's bodies, in the previous team
  std::vector<double> ages_;      // of each body's measurement [s]
  std::size_t signalled_ = 0;     // number of signals sent
  bool changed_ = false;          // in this period
};

}  // namespace sightline::stages
