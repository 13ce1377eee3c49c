/// The horizon of most tests.
#pragma once

#include "sightline/team.hpp"

namespace sightline {

inline constexpr Horizon default_horizon;  ///< 20 stages of 0.05 s, every 0.01 s

}  // namespace sightline
