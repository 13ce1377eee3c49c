/// Selection of the neighbours that threaten a robot, and the best plan to evade each.
#pragma once

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

/// Whether a barrier can use a neighbour: an unbounded acceleration is allowed.
bool is_finite(const Neighbour& neighbour) noexcept;

/// Adds the neighbours of the period that matter, each with its plan.
/// @return whether all neighbours have finite numbers
bool find_threats(const BarrierLaw& law, BarrierPeriod& now) noexcept;

}  // namespace sightline
