/// A sink for a producer's items, and a lock-free ring buffer for one producer and one consumer.
#pragma once

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <vector>

namespace sightline {

/// Takes a producer's items one at a time, in the producer's thread; allocates nothing.
template <class T>
class Sink {
 public:
  virtual ~Sink() = default;

  /// The next item to write, or nullptr if there is no room.
  virtual T* claim() noexcept = 0;
  /// Whether the sink takes items between the regular ones.
  virtual bool takes_between() const noexcept { return false; }
  /// As claim(), for an item between the regular ones.
  virtual T* claim_between() noexcept { return nullptr; }
  /// Takes over the claimed item.
  virtual void publish() noexcept = 0;
  /// Receives an item that found no room. A sink that acts on items or displays them acts on this
  /// item, too. It does not keep the item.
  virtual void drop(const T&) noexcept {}
  /// Ends the stream: no item follows.
  virtual void close() noexcept = 0;
  /// Whether the consumer has stopped: claim() then never has room again.
  virtual bool is_abandoned() const noexcept { return false; }
};

/// Items are made once, as copies of a prototype, and are written and read in place. There are no
/// locks. The producer never waits and does not wake the consumer, which polls.
template <class T>
class SpscQueue final : public Sink<T> {
 public:
  /// @param capacity  items that can wait, >= 1
  /// @param between  claim_between() requires fewer waiting items than this; 0: it never has room
  SpscQueue(std::size_t capacity, const T& prototype, std::size_t between = 0)
      : items_(capacity, prototype), between_(between) {
    assert(capacity > 0 && "a ring holds something");
  }

  /// Producer: the next item to write, or nullptr if the ring is full.
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
  /// Producer: publishes the claimed item.
  void publish() noexcept override {
    written_.store(written_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }
  /// Producer: ends the stream.
  void close() noexcept override { closed_.store(true, std::memory_order_release); }
  bool is_abandoned() const noexcept override { return abandoned_.load(std::memory_order_acquire); }

  /// Consumer: the oldest item, or nullptr if the ring is empty.
  const T* front() const noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (written_.load(std::memory_order_acquire) == read) return nullptr;
    return &items_[read % items_.size()];
  }
  /// Consumer: releases the item at the front.
  void pop() noexcept { read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  /// Consumer, or its owner if it never started: stops taking items.
  void abandon() noexcept { abandoned_.store(true, std::memory_order_release); }
  /// Consumer: waits for the oldest item; nullptr if the ring is closed and empty.
  const T* wait() const noexcept {
    // Each sleep costs about 10 us, so the sleeps grow with the wait, from 0.2 ms.
    constexpr long longest = 3'200'000;  // [ns]
    for (timespec nap = {0, 200'000};; nap.tv_nsec = std::min(longest, 2 * nap.tv_nsec)) {
      const bool last = closed_.load(std::memory_order_acquire);  // must precede front()
      if (const T* item = front()) return item;
      if (last) return nullptr;
      ::nanosleep(&nap, nullptr);
    }
  }

  std::size_t capacity() const noexcept { return items_.size(); }

 private:
  std::vector<T> items_;
  std::size_t between_;
  // Total counts of items, each on its own cache line.
  alignas(64) std::atomic<std::size_t> written_{0};
  alignas(64) std::atomic<std::size_t> read_{0};
  std::atomic<bool> closed_{false}, abandoned_{false};
};

}  // namespace sightline
