/// Counts what a thread takes from the heap: the promise of an update without allocation is checked, not
/// believed.
#pragma once

#include <cstdint>

namespace sightline::cli {

/// Calls of malloc, calloc, realloc, aligned_alloc, posix_memalign and operator new by the calling thread so
/// far. Zero in a build with sanitizers, which bring a heap of their own.
std::int64_t allocations() noexcept;

/// Whether this build counts.
bool counts_allocations() noexcept;

}  // namespace sightline::cli
