/// Calls of user functions in the control path: an exception becomes results that are NaN. A call
/// that does not throw costs nothing extra.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>

namespace sightline {

/// f(), or NaN if f throws.
template <class F>
double or_nan(F&& f) noexcept {
  try {
    return f();
  } catch (...) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

/// Calls `write`, which writes n numbers to `to`; all are NaN if it throws.
template <class Write>
void write_or_nan(double* to, std::size_t n, Write&& write) noexcept {
  try {
    write();
  } catch (...) {
    std::fill_n(to, n, std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace sightline
