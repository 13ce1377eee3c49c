// The operators new of a test program, which count, and fail where a test asks for it.
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "tests/support/counted_new.hpp"

static thread_local std::int64_t counted_allocations = 0;
std::int64_t sightline::allocations_here() noexcept { return counted_allocations; }

static thread_local bool has_memory = false;  // while others have none
static std::atomic<bool> memory_fails{false};
static std::atomic<std::int64_t> failed_allocations{0};

sightline::NoMemoryElsewhere::NoMemoryElsewhere() noexcept {
  has_memory = true;
  failed_allocations = 0;
  memory_fails = true;
}
sightline::NoMemoryElsewhere::~NoMemoryElsewhere() {
  memory_fails = false;
  has_memory = false;
}
std::int64_t sightline::NoMemoryElsewhere::failed() const noexcept { return failed_allocations; }

// Not inlined: GCC 12 would take malloc's memory for a mismatch with delete.
[[gnu::noinline]] void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  ++counted_allocations;
  if (memory_fails.load(std::memory_order_relaxed) && !has_memory) {
    ++failed_allocations;
    return nullptr;
  }
  return std::malloc(bytes);
}
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  if (void* memory = operator new(bytes, std::nothrow)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
