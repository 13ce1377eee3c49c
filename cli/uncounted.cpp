// Null implementation of the counters for other programs, which keep their own heap. A program that
// links allocations.cpp counts.
#include "cli/allocations.hpp"

namespace sightline::cli {

std::int64_t allocations() noexcept { return 0; }
bool counts_allocations() noexcept { return false; }

}  // namespace sightline::cli
