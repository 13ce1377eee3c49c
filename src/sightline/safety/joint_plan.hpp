/// One evasive plan against several uncooperative neighbours at once.
#pragma once

#include "sightline/safety/barrier_period.hpp"

namespace sightline {

/// Finds one plan for all uncooperative neighbours, and gives it to the threats.
/// @return its reserve [m]; infinity if the single plans suffice, minus infinity without a plan
double join_plans(const BarrierLaw& law, BarrierPeriod& now) noexcept;

}  // namespace sightline
