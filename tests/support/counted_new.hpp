/// Counts what tests allocate.
#pragma once

#include <cstdint>

namespace sightline {

/// By operator new, on this thread, so far; of a program that counting_new.cpp is a part of.
std::int64_t allocations_here() noexcept;

}  // namespace sightline
