/// Nonlinear check of a command against its rows, and the replacement of a command that fails.
#pragma once

#include <span>

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

/// The tube of the rest of a plan, after a period that ends in `after`.
Tube rest_of(const BarrierLaw& law, const BarrierPeriod& now, const Tube& tube,
             const NextState& after) noexcept;
/// Makes u keep the bounds of the world and of zones if braking does.
/// @param after  state under u
void ensure_walls(const BarrierLaw& law, const BarrierPeriod& now, std::span<double> u,
                  NextState& after) noexcept;
/// Makes u keep the distances if a plan of this period proves that this is possible. This covers
/// uncooperative neighbours alone, or one cooperative neighbour. Floor, ceiling, world and
/// zones are violated no further.
/// @param after  state under u
/// @return whether u keeps the distances
bool ensure_distances(const BarrierLaw& law, const BarrierPeriod& now, std::span<double> u,
                      NextState& after) noexcept;

}  // namespace sightline
