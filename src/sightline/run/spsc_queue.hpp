/// Where a producer leaves its items, and a ring of preallocated ones between one producer, which is never held
/// up, and one consumer.
#pragma once

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <vector>

namespace sightline {

/// Takes a producer's items one at a time, in its thread; allocates nothing.
template <class T>
class Sink {
 public:
  virtual ~Sink() = default;

  /// The next item to write, or nullptr where there is no room for one now.
  virtual T* claim() noexcept = 0;
  /// Whether it takes items between the regular ones.
  virtual bool takes_between() const noexcept { return false; }
  /// As claim(), for an item between the regular ones.
  virtual T* claim_between() noexcept { return nullptr; }
  /// Takes over the claimed item.
  virtual void publish() noexcept = 0;
  /// An item that found no room: whoever acts on items or shows them acts on this one, too. It is not kept.
  virtual void drop(const T&) noexcept {}
  /// Nothing comes after what was published.
  virtual void close() noexcept = 0;
  /// Whether nobody takes items any more: claim() then never has room again.
  virtual bool is_abandoned() const noexcept { return false; }
};

/// Items are made once, as copies of a prototype, and written and read where they are. No locks: the producer
/// does not even wake the consumer, which looks every now and then.
template <class T>
class SpscQueue final : public Sink<T> {
 public:
  /// @param capacity  items that can wait, >= 1
  /// @param between   of them at most when one between the regular items is claimed; 0: takes none of these
  SpscQueue(std::size_t capacity, const T& prototype, std::size_t between = 0)
      : items_(capacity, prototype), between_(between) {
    assert(capacity > 0 && "a ring holds something");
  }

  /// Producer: the next item to write, or nullptr where all wait to be read.
  T* claim() noexcept override {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == items_.size()) return nullptr;
    return &items_[written % items_.size()];
  }
  bool takes_between() const noexcept override { return between_ > 0; }
  T* claim_between() noexcept override {
    const std::size_t waiting =
        written_.load(std::memory_order_relaxed) - read_.load(std::memory_order_acquire);
    return waiting < between_ ? claim() : nullptr;
  }
  /// Producer: hands over the claimed item.
  void publish() noexcept override {
    written_.store(written_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }
  /// Producer: nothing comes after what was published.
  void close() noexcept override { closed_.store(true, std::memory_order_release); }
  bool is_abandoned() const noexcept override { return abandoned_.load(std::memory_order_acquire); }

  /// Consumer: the oldest item, or nullptr where none waits.
  const T* front() const noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (written_.load(std::memory_order_acquire) == read) return nullptr;
    return &items_[read % items_.size()];
  }
  /// Consumer: done with the item at the front.
  void pop() noexcept { read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  /// Consumer, or who should have been: no item is taken any more.
  void abandon() noexcept { abandoned_.store(true, std::memory_order_release); }
  /// Consumer: the oldest item, as soon as there is one; nullptr when the ring is closed and empty.
  const T* wait() const noexcept {
    // Each nap costs some 10 us: the longer it waits, the longer they are, from 0.2 ms.
    constexpr long longest = 3'200'000;  // [ns]
    for (timespec nap = {0, 200'000};; nap.tv_nsec = std::min(longest, 2 * nap.tv_nsec)) {
      const bool last = closed_.load(std::memory_order_acquire);  // before the look at the front
      if (const T* item = front()) return item;
      if (last) return nullptr;
      ::nanosleep(&nap, nullptr);
    }
  }

  std::size_t capacity() const noexcept { return items_.size(); }

 private:
  std::vector<T> items_;
  std::size_t between_;
  // Counts of all items ever, each on a cache line of its own.
  alignas(64) std::atomic<std::size_t> written_{0};
  alignas(64) std::atomic<std::size_t> read_{0};
  std::atomic<bool> closed_{false}, abandoned_{false};
};

}  // namespace sightline
