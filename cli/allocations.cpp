#include "cli/allocations.hpp"

#include <cerrno>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SIGHTLINE_COUNTS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SIGHTLINE_COUNTS 0
#endif
#endif
#if !defined(SIGHTLINE_COUNTS) && defined(__GLIBC__)
#define SIGHTLINE_COUNTS 1
#endif

#if SIGHTLINE_COUNTS

// The C library's own heap, behind the names replaced here; operator new calls malloc.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
}
// NOLINTEND(bugprone-reserved-identifier)

namespace {
thread_local std::int64_t count = 0;
}

extern "C" {
void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  ++count;
  return __libc_calloc(n, size);
}
void* realloc(void* memory, std::size_t size) {
  ++count;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++count;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++count;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}

namespace sightline::cli {
std::int64_t allocations() noexcept { return count; }
bool counts_allocations() noexcept { return true; }
}  // namespace sightline::cli

#else

namespace sightline::cli {
std::int64_t allocations() noexcept { return 0; }
bool counts_allocations() noexcept { return false; }
}  // namespace sightline::cli

#endif
