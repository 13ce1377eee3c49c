/// Lock-free mailbox that holds the newest value.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sightline::dds {

/// One thread writes, any number of threads read; neither waits. A sequence lock with atomic words:
/// a read that collides with writes 64 times returns false and leaves `value` unchanged, so the
/// reader keeps its previous value.
template <class T>
class Mailbox {
  static_assert(std::is_trivially_copyable_v<T>);
  static constexpr std::size_t words = (sizeof(T) + 7) / 8;
  using Words = std::array<std::uint64_t, words>;

 public:
  /// Writing thread only.
  void put(const T& value) noexcept {
    Words raw{};
    std::memcpy(raw.data(), &value, sizeof value);
    const std::uint64_t n = puts_.load(std::memory_order_relaxed);
    puts_.store(n + 1, std::memory_order_relaxed);
    // Release, paired with the reader's acquire: a reader that loads a new word also loads the odd
    // count.
    for (std::size_t i = 0; i < words; ++i) raw_[i].store(raw[i], std::memory_order_release);
    puts_.store(n + 2, std::memory_order_release);
  }

  /// Copies the newest value into `value`.
  /// @return false, with `value` unchanged, if nothing was put yet or 64 reads collided with a
  ///   write
  bool look(T& value) const noexcept {
    for (int tries = 0; tries < 64; ++tries) {
      const std::uint64_t n = puts_.load(std::memory_order_acquire);
      if (n == 0) return false;
      if (n % 2 != 0) continue;
      Words raw;
      for (std::size_t i = 0; i < words; ++i) raw[i] = raw_[i].load(std::memory_order_acquire);
      if (puts_.load(std::memory_order_relaxed) != n) continue;
      std::memcpy(static_cast<void*>(&value), raw.data(), sizeof value);
      return true;
    }
    return false;
  }

  /// Number of values put so far.
  std::uint64_t count() const noexcept { return puts_.load(std::memory_order_acquire) / 2; }

 private:
  std::atomic<std::uint64_t> puts_{0};  // odd while a write is in progress
  std::array<std::atomic<std::uint64_t>, words> raw_{};
};

}  // namespace sightline::dds
