/// Conversions of indices: item numbers are int; container indices and sizes are std::size_t.
#pragma once

#include <cassert>
#include <cstddef>

namespace sightline {

/// The container index of item i, i >= 0.
constexpr std::size_t at(int i) {
  assert(i >= 0 && "a place is not negative");
  return static_cast<std::size_t>(i);
}

/// The container size for n items, n >= 0.
constexpr std::size_t size(int n) {
  assert(n >= 0 && "a size is not negative");
  return static_cast<std::size_t>(n);
}

}  // namespace sightline
