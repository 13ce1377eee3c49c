#include "cli/allocations.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <thread>

namespace sightline::cli {
namespace {

template <class F>
std::int64_t counted(F&& f) {
  const std::int64_t before = allocations();
  f();
  return allocations() - before;
}

TEST(Allocations, EveryWayToTheHeapIsCounted) {
  const std::int64_t one = counts_allocations() ? 1 : 0;
  EXPECT_EQ(counted([] {}), 0);
  void* volatile kept = nullptr;  // the compiler must not drop the pair
  EXPECT_EQ(counted([&] { kept = std::malloc(10); }), one);
  EXPECT_EQ(counted([&] { kept = std::realloc(kept, 100000); }), one);
  std::free(kept);
  EXPECT_EQ(counted([&] { kept = std::calloc(3, 5); }), one);
  std::free(kept);
  EXPECT_EQ(counted([&] { kept = std::aligned_alloc(64, 128); }), one);
  std::free(kept);
  EXPECT_EQ(counted([&] { kept = ::operator new(10); }), one);
  ::operator delete(kept);
  EXPECT_EQ(counted([&] { kept = ::operator new(64, std::align_val_t(64)); }), one);
  ::operator delete(kept, std::align_val_t(64));
}

TEST(Allocations, AnotherThreadsAllocationsAreNotOurs) {
  std::thread other;
  EXPECT_EQ(counted([] {}), 0);
  std::atomic<bool> go{false}, done{false};
  other = std::thread([&] {
    while (!go) std::this_thread::yield();
    for (int i = 0; i < 100; ++i) std::make_unique<std::array<char, 100>>().reset();
    done = true;
  });
  EXPECT_EQ(counted([&] {
              go = true;
              while (!done) std::this_thread::yield();
            }),
            0);
  other.join();
}

}  // namespace
}  // namespace sightline::cli
