/// Comparison of times: they are sums or multiples of periods, so equal times differ by rounding.
#pragma once

namespace sightline {

/// Times that differ by less are equal [s].
inline constexpr double same_time = 1e-9;

}  // namespace sightline
