/// Threads that share the parts of one piece of work after the other, fast enough for the phases of a control update.
///
///   crew.share(groups, [&](int group, int thread) noexcept { ... });
///
/// Each part is done once, by anyone, and all are done when share() returns. What a part computes must not depend on the other parts
/// nor on the thread; then the result does not depend on how many threads there are. Sums over parts are taken afterwards, in order.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "sightline/base/subnormals.hpp"

namespace sightline {

class ServiceThread;

/// Memory and threads are taken when it is made; share() neither allocates nor locks. The others wait for work by looking for it
/// for some microseconds, then asleep. Whoever shares works too and takes over what another thread has not begun, so a thread that
/// the machine holds up costs the parts it is at, no more. They compute in the floating point mode of whoever shares.
class ThreadPool {
 public:
  static constexpr int most = 64;  ///< threads

  /// @param threads  with the one that shares, 1 to `most`; 1: no thread is started
  /// @throws std::invalid_argument for another number of threads, std::system_error where the machine has none
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return threads_; }

  /// work(part, thread) for each part of 0 .. parts - 1; thread is below threads(), and no two parts at once are told the same.
  /// Where another thread shares at this moment, or within a part, the caller does it all.
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

  /// Parts of one thread that nobody has begun, of which job: packed, so that one step takes a part of the job that is on or none.
  struct alignas(64) Range {
    std::atomic<std::uint64_t> word{0};
  };

  bool share_out(int parts, Call call, void* work) noexcept;
  void work_on(int thread) noexcept;
  bool take(Range& range, int& part) noexcept;
  void wait_for_work(int thread) noexcept;
  void end() noexcept;

  int threads_;
  // Of the job that is on: written before its ranges, read after a part of them was taken.
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

/// That crew where it is there and pays, else one that shares nothing.
std::shared_ptr<ThreadPool> thread_pool_if(bool pays, std::shared_ptr<ThreadPool> pool);

}  // namespace sightline
