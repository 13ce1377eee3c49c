/// Heap allocations per thread, counted so that a test can verify an update that must not allocate.
#pragma once

#include <cstdint>

namespace sightline::cli {

/// Calls of malloc, calloc, realloc, aligned_alloc, posix_memalign and operator new by the calling
/// thread so far. Zero in a build with sanitizers, which replace the heap.
std::int64_t allocations() noexcept;

/// Whether this build counts allocations.
bool counts_allocations() noexcept;

}  // namespace sightline::cli
