/// Counts what tests allocate.
#pragma once

#include <cstdint>

namespace sightline {

/// By operator new, on this thread, so far; of a program one of whose files includes counting_new.hpp.
std::int64_t allocations_here() noexcept;

}  // namespace sightline
