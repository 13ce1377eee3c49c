/// Counts what the tests of run allocate.
#pragma once

#include <cstdint>

namespace sightline {

/// By operator new, on this thread, so far; loop_test.cpp replaces that operator for its program.
std::int64_t allocations_here() noexcept;

}  // namespace sightline
