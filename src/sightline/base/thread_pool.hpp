/// A fork-join thread pool for tasks of microseconds: the phases of a control update.
///
///   pool.share(groups, [&](int group, int thread) noexcept { ... });
///
/// Any thread runs each part once, and all parts are done when share() returns. The result of a
/// part must not depend on other parts or on the thread. Then the results do not depend on the
/// number of threads. Sums over parts are computed afterwards, in order.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "sightline/base/subnormals.hpp"

namespace sightline {

class ServiceThread;

/// The constructor allocates memory and starts threads; share() neither allocates nor locks.
/// Workers spin for some microseconds for work, then sleep. The caller of share() works too. Each
/// thread takes over parts that another thread has not begun, so a preempted thread delays only the
/// part it runs. Workers compute in the floating point mode of the caller.
class ThreadPool {
 public:
  static constexpr int most = 64;  ///< maximum number of threads

  /// @param threads  including the calling thread, 1 to `most`; 1: no thread is started
  /// @throws std::invalid_argument for another number of threads, std::system_error if the machine
  ///   has no thread
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return threads_; }

  /// Calls work(part, thread) for each part of 0 .. parts - 1. `thread` is below threads() and
  /// differs between parts that run at the same time. If another thread is in share(), or the call
  /// is nested in a part, the caller runs all parts.
  template <class Work>
  void share(int parts, Work&& work) noexcept {
    const Call call = [](void* at, int part, int thread) {
      (*static_cast<std::remove_reference_t<Work>*>(at))(part, thread);
    };
    if (threads_ > 1 && parts > 1 &&
        share_out(parts, call, const_cast<void*>(static_cast<const void*>(&work))))
      return;
    for (int part = 0; part < parts; ++part) work(part, 0);
  }

 private:
  using Call = void (*)(void* work, int part, int thread);

  /// The parts of one thread that have not begun, and their job. They are packed in one word, so
  /// that one atomic step takes a part of the current job or none.
  struct alignas(64) Range {
    std::atomic<std::uint64_t> word{0};
  };

  bool share_out(int parts, Call call, void* work) noexcept;
  void work_on(int thread) noexcept;
  bool take(Range& range, int& part) noexcept;
  void wait_for_work(int thread) noexcept;
  void end() noexcept;

  int threads_;
  // State of the current job: written before its ranges, read after one of its parts was taken.
  Call call_ = nullptr;
  void* work_ = nullptr;
  int parts_ = 0;
  FloatMode mode_{};
  std::unique_ptr<Range[]> ranges_;  // of each thread
  alignas(64) std::atomic<std::uint32_t> job_{0};
  alignas(64) std::atomic<int> done_{0};
  std::atomic<bool> busy_{false}, stop_{false};
  std::unique_ptr<std::unique_ptr<ServiceThread>[]> others_;
};

/// The given pool if it exists and pays, else a pool of one thread.
std::shared_ptr<ThreadPool> thread_pool_if(bool pays, std::shared_ptr<ThreadPool> pool);

}  // namespace sightline
