#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {
namespace {

TEST(ThreadPool, EachPartIsDoneOnceWhateverTheThreads) {
  for (const int threads : {1, 2, 3, 8}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const int parts : {0, 1, 2, 3, 7, 64, 1000}) {
      std::vector<int> times(static_cast<std::size_t>(parts), 0);
      for (int job = 0; job < 50; ++job)
        pool.share(parts, [&](int part, int thread) noexcept {
          if (thread >= 0 && thread < threads) ++times[static_cast<std::size_t>(part)];
        });
      for (const int count : times) EXPECT_EQ(count, 50) << threads << " threads, " << parts << " parts";
    }
  }
}

TEST(ThreadPool, ItsThreadsSleepAndComeBack) {
  ThreadPool pool(2);
  std::atomic<int> sum = 0;
  for (int job = 0; job < 20; ++job) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    pool.share(10, [&](int part, int) noexcept { sum += part; });
  }
  EXPECT_EQ(sum, 20 * 45);
}

TEST(ThreadPool, WhoSharesWhileAnotherDoesOrWithinAPartDoesItAllAlone) {
  ThreadPool pool(2);
  std::vector<std::atomic<int>> sums(3);
  const auto count = [&](std::size_t i) {
    for (int job = 0; job < 200; ++job)
      pool.share(10, [&, i](int part, int) noexcept {
        sums[i] += part;
        if (part == 5) pool.share(2, [&](int, int) noexcept { ++sums[2]; });
      });
  };
  std::thread other(count, 0);
  count(1);
  other.join();
  EXPECT_EQ(sums[0], 200 * 45);
  EXPECT_EQ(sums[1], 200 * 45);
  EXPECT_EQ(sums[2], 2 * 200 * 2);
}

TEST(ThreadPool, ComputesInTheModeOfWhoSharesIt) {
  ThreadPool pool(2);
  std::vector<double> tiny(64);
  volatile double small = 1e-308;
  const auto halves = [&](int part, int) noexcept {
    volatile double half = small * 0.25;
    tiny[static_cast<std::size_t>(part)] = half;
  };
  {
    const FlushSubnormals flush;
    pool.share(64, halves);
  }
  volatile double flushed = 0.0;
  {
    const FlushSubnormals flush;
    flushed = small * 0.25;
  }
  for (const double t : tiny) EXPECT_EQ(t, flushed);
  pool.share(64, halves);
  for (const double t : tiny) EXPECT_GT(t, 0.0);
}

TEST(ThreadPool, RefusesNoThreadAndTooMany) {
  EXPECT_THROW(ThreadPool(0), std::invalid_argument);
  EXPECT_THROW(ThreadPool(65), std::invalid_argument);
}

}  // namespace
}  // namespace sightline
