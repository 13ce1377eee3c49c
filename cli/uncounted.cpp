// For programs of others, whose heap is their own: nothing is counted. A program that links allocations.cpp counts.
#include "cli/allocations.hpp"

namespace sightline::cli {

std::int64_t allocations() noexcept { return 0; }
bool counts_allocations() noexcept { return false; }

}  // namespace sightline::cli
