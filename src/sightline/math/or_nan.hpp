/// The seam to a user's functions: what they throw has no way out of the control path, and stands there as numbers
/// that are none. A function that throws nothing costs nothing.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

namespace sightline {

/// f(), or NaN where it throws.
template <class F>
double or_nan(F&& f) noexcept {
  try {
    return f();
  } catch (...) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

/// Lets `write` write n numbers to `to`; all NaN where it throws.
template <class Write>
void write_or_nan(double* to, std::size_t n, Write&& write) noexcept {
  try {
    write();
  } catch (...) {
    std::fill_n(to, n, std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace sightline
