/// The evasive manoeuvre of a surrounded robot: whether it must be flown, and its command.
#pragma once

#include <span>

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

bool is_surrounded(const BarrierLaw& law, const BarrierPeriod& now) noexcept;
/// Selects an evasive manoeuvre, unless one remains possible after the command that leads to
/// `after`.
/// @return whether the robot must fly the manoeuvre
bool choose_maneuver(const BarrierLaw& law, const BarrierPeriod& now, const NextState& after,
                     bool contradicted, EvasiveManeuver& maneuver) noexcept;
/// Sets u to the command that flies the manoeuvre; inputs without an effect on it are zero.
void fly_maneuver(const BarrierLaw& law, const BarrierPeriod& now, EvasiveManeuver& maneuver,
                  std::span<double> u) noexcept;

}  // namespace sightline
