/// Stages "filter", "gate" and "apply": from the controllers' inputs to the world.
#pragma once

#include <algorithm>
#include <chrono>

#include "sightline/loop.hpp"
#include "sightline/run/stages/log.hpp"
#include "sightline/run/stages/period.hpp"

namespace sightline::stages {

/// Changes the inputs so that they keep limits, rates and, by the guard, the certified views and
/// the hard distances.
class Filter {
 public:
  Filter(Guard* guard, const Period& p) : guard_(guard), plan_ages_(p.planned_at.size()) {}

  void run(Period& p) noexcept {
    p.gate.open(p.t);
    if (guard_ != nullptr) {
      for (std::size_t i = 0; i < plan_ages_.size(); ++i) plan_ages_[i] = p.t - p.planned_at[i];
      guard_->fall_back(p.t, *p.met, plan_ages_, p.added, p.u);
    }
    p.gate.keep_limits_and_rates(p.u, p.added);
    if (guard_ == nullptr) return;
    guard_->keep_distances(p.t, *p.met, p.added, p.u);
    for (const Event& event : guard_->events()) p.emit(event);
    std::ranges::copy(guard_->barriers(), p.sample->barriers.begin());
    std::ranges::copy(guard_->views(), p.sample->views.begin());
    std::ranges::copy(guard_->levels(), p.sample->levels.begin());
  }

 private:
  Guard* guard_;
  std::vector<double> plan_ages_;  // of each body [s]
};

/// Passes the inputs through the gate: the command that is in force from now on.
struct Gate {
  Guard* guard;
  Compensation* compensation;

  void run(Period& p) noexcept {
    const Command command = p.gate.pass(p.u, compensation != nullptr ? p.added : std::span<const double>{});
    for (const BodyId robot : p.gate.replaced()) {
      ++p.outcome.refused;
      p.emit({p.t, EventKind::input_refused, 0, static_cast<double>(robot.index)});
    }
    if (compensation != nullptr) compensation->record(p.t, command);
    if (guard != nullptr) guard->record(p.t, command);
    std::copy(command.begin(), command.end(), p.sample->u.begin());
    p.sample->update_us =
        std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - p.began).count();
  }
};

/// Applies the command to the world.
struct Apply {
  World& world;
  Localizer* localizer;
  Log& log;
  double period;  // [s]

  void run(Period& p) noexcept { run(p, p.t, 1); }
  /// Applies the command from `begin` on. If several periods pass and the truth is known, the log
  /// receives the states at the end of each but the last, as far as it has room.
  void run(Period& p, double begin, std::int64_t periods) noexcept {
    if (localizer != nullptr) localizer->apply(p.gate.applied(), period, periods);
    const bool shows = periods > 1 && p.outcome.updates > 0 && !world.truth().empty();
    const std::int64_t together = shows ? 1 : periods;
    for (std::int64_t k = 0; k < periods; k += together) {
      const double from = begin + static_cast<double>(k) * period;
      if (!world.apply(from, *p.estimate, p.gate.applied(), period, together)) {
        p.outcome.finite = false;
        return;
      }
      if (k + together < periods) log.show(p, from + period, world.truth());
    }
  }
};

}  // namespace sightline::stages
