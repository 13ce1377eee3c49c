/// Numbers of things are int; places in containers, and their sizes, are std::size_t.
#pragma once

#include <cassert>
#include <cstddef>

namespace sightline {

/// The place of thing i, i >= 0.
constexpr std::size_t at(int i) {
  assert(i >= 0 && "a place is not negative");
  return static_cast<std::size_t>(i);
}

/// The size of n things, n >= 0.
constexpr std::size_t size(int n) {
  assert(n >= 0 && "a size is not negative");
  return static_cast<std::size_t>(n);
}

}  // namespace sightline
