/// Counts what tests allocate, and lets allocations fail; of a program that counting_new.cpp is a
/// part of.
#pragma once

#include <cstdint>

namespace sightline {

/// By operator new, on this thread, so far.
std::int64_t allocations_here() noexcept;

/// While it lives, operator new has no memory for any thread but the one that made it.
class NoMemoryElsewhere {
 public:
  NoMemoryElsewhere() noexcept;
  ~NoMemoryElsewhere();
  NoMemoryElsewhere(const NoMemoryElsewhere&) = delete;
  NoMemoryElsewhere& operator=(const NoMemoryElsewhere&) = delete;

  /// Allocations that failed so far.
  std::int64_t failed() const noexcept;
};

}  // namespace sightline
