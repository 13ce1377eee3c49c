/// Times are sums or multiples of periods, so two of one moment differ by rounding.
#pragma once

namespace sightline {

/// Times that differ by less are the same [s].
inline constexpr double same_time = 1e-9;

}  // namespace sightline
