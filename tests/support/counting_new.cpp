// The operators new of a test program, which count.
#include <cstdint>
#include <cstdlib>
#include <new>

#include "tests/support/counted_new.hpp"

static thread_local std::int64_t counted_allocations = 0;
std::int64_t sightline::allocations_here() noexcept { return counted_allocations; }

// Not inlined: GCC 12 would take malloc's memory for a mismatch with delete.
[[gnu::noinline]] void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  ++counted_allocations;
  return std::malloc(bytes);
}
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  if (void* memory = operator new(bytes, std::nothrow)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
