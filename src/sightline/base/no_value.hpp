#pragma once

#include <limits>

namespace sightline {

/// Marks a value that does not exist.
inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace sightline
