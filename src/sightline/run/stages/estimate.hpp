/// Stages "supervise" and "compensate": from valid states to the states where commands take effect.
#pragma once

#include "sightline/loop.hpp"
#include "sightline/run/stages/period.hpp"

namespace sightline::stages {

/// The guard's estimate of all states, which refuses faulty measurements.
struct Supervise {
  Guard* guard;
  const Localizer* localizer;

  void run(Period& p) noexcept {
    if (guard == nullptr) return;
    p.estimate = &guard->accept_measurement(
        p.t, p.seen.measured, p.seen.stamps,
        localizer != nullptr ? localizer->sigma() : std::span<const double>{},
        localizer != nullptr ? localizer->estimates() : std::span<const PoseEstimate>{});
    if (localizer != nullptr) guard->look(p.t, localizer->views());
  }
};

/// Predicts the states at which the commands of this period take effect.
class Compensate {
 public:
  Compensate(Compensation* compensation, const Guard* guard, Period& p)
      : compensation_(compensation), guard_(guard), none_(p.u.size()), met_(p.measured) {
    p.added = none_;
    if (compensation_ == nullptr) return;
    p.added = compensation_->added();
    p.added_lean = compensation_->lean();
    p.lead = compensation_->lead();
  }

  void run(Period& p) noexcept {
    p.met = p.estimate;
    if (compensation_ == nullptr) return;
    for (int i = 0; i < static_cast<int>(p.presence.size()); ++i) {
      const bool trusted = guard_ == nullptr || guard_->trusts(BodyId{i});
      if (trusted && p.presence[size(i)] != Presence::absent) compensation_->look(BodyId{i}, p.measured);
    }
    p.met = &met_.take(compensation_->ahead(p.t, *p.estimate), *p.estimate);
  }

 private:
  Compensation* compensation_;
  const Guard* guard_;
  std::vector<double> none_;  // zero
  ValidStates met_;
};

}  // namespace sightline::stages
