/// The nearest command that keeps all rows of a period, by rounds of linearisation and projection.
#pragma once

#include <span>

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

inline constexpr double corrected = 1e-5;  // [m] tolerance of the linearised step

/// Replaces u, which leads to `nominal`; adds rows where the command moves the time of a least gap.
/// @return the largest violation [m]
double project_on_rows(const BarrierLaw& law, const NextState& nominal, BarrierPeriod& now,
                       std::span<double> u) noexcept;

}  // namespace sightline
