/// Calls of a user's functions in the control path: an exception does not leave it, but gives results that are
/// NaN. A function that throws nothing costs nothing.
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
