#include <stdexcept>
#include <string>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr int looks = 2000;         // spins before a thread sleeps: about 50 us
constexpr int parts_most = 0xffff;  // of a job

void pause() {
#if defined(__SSE2__)
  _mm_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Returns when the number differs from `old`: spins first, then sleeps.
template <class Number>
Number wait_for_news(const std::atomic<Number>& number, Number old) noexcept {
  for (int look = 0; look < looks; ++look) {
    if (const Number now = number.load(std::memory_order_acquire); now != old) return now;
    pause();
  }
  number.wait(old, std::memory_order_acquire);
  return number.load(std::memory_order_acquire);
}

constexpr std::uint64_t packed(std::uint32_t job, int next, int end) {
  return std::uint64_t{job} << 32 | static_cast<std::uint64_t>(next) << 16 | static_cast<std::uint64_t>(end);
}

}  // namespace

ThreadPool::ThreadPool(int threads) : threads_(threads) {
  if (threads < 1 || threads > most)
    throw std::invalid_argument("threads = " + std::to_string(threads) + ", expected 1 to " +
                                std::to_string(most));
  ranges_ = std::make_unique<Range[]>(static_cast<std::size_t>(threads));
  others_ = std::make_unique<std::unique_ptr<ServiceThread>[]>(static_cast<std::size_t>(threads));
  try {
    for (int t = 1; t < threads; ++t) {
      auto& other = others_[static_cast<std::size_t>(t)] =
          std::make_unique<ServiceThread>("a solver's thread");
      other->start_or_throw([this, t]() noexcept { wait_for_work(t); });
    }
  } catch (...) {
    end();  // stops the threads that already wait
    throw;
  }
}

std::shared_ptr<ThreadPool> thread_pool_if(bool pays, std::shared_ptr<ThreadPool> pool) {
  return pool != nullptr && pays ? std::move(pool) : std::make_shared<ThreadPool>(1);
}

ThreadPool::~ThreadPool() { end(); }

void ThreadPool::end() noexcept {
  stop_.store(true, std::memory_order_relaxed);
  job_.fetch_add(1, std::memory_order_release);
  job_.notify_all();
}

bool ThreadPool::share_out(int parts, Call call, void* work) noexcept {
  if (parts > parts_most || busy_.exchange(true, std::memory_order_acquire)) return false;
  call_ = call;
  work_ = work;
  parts_ = parts;
  mode_ = float_mode();
  done_.store(0, std::memory_order_relaxed);
  const std::uint32_t job = job_.load(std::memory_order_relaxed) + 1;
  for (int t = 0; t < threads_; ++t)
    ranges_[static_cast<std::size_t>(t)].word.store(
        packed(job, t * parts / threads_, (t + 1) * parts / threads_), std::memory_order_release);
  job_.store(job, std::memory_order_release);
  job_.notify_all();
  work_on(0);
  for (int done = done_.load(std::memory_order_acquire); done < parts;) done = wait_for_news(done_, done);
  busy_.store(false, std::memory_order_release);
  return true;
}

bool ThreadPool::take(Range& range, int& part) noexcept {
  std::uint64_t word = range.word.load(std::memory_order_acquire);
  for (;;) {
    const int next = static_cast<int>(word >> 16 & 0xffff), end = static_cast<int>(word & 0xffff);
    if (next >= end) return false;
    part = next;
    if (range.word.compare_exchange_weak(word, word + (1 << 16), std::memory_order_acq_rel,
                                         std::memory_order_acquire))
      return true;
  }
}

/// Runs the thread's own parts, then parts that other threads have not begun. The job cannot end
/// before the parts counted in `did` are added to `done_`.
void ThreadPool::work_on(int thread) noexcept {
  for (int i = 0; i < threads_; ++i) {
    Range& range = ranges_[static_cast<std::size_t>((thread + i) % threads_)];
    int part = 0, did = 0;
    while (take(range, part)) {
      if (did++ == 0 && thread > 0) set_float_mode(mode_);
      call_(work_, part, thread);
    }
    if (did == 0) continue;
    const int parts = parts_;
    if (done_.fetch_add(did, std::memory_order_acq_rel) + did == parts) done_.notify_one();
  }
}

void ThreadPool::wait_for_work(int thread) noexcept {
  std::uint32_t seen = 0;
  for (;;) {
    seen = wait_for_news(job_, seen);
    if (stop_.load(std::memory_order_relaxed)) return;
    work_on(thread);
  }
}

}  // namespace sightline
