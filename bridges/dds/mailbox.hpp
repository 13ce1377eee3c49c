/// The newest of something, from one thread to others, without locks.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sightline::dds {

/// One thread puts, any number of threads look. Nobody waits: a look that meets writes again and again gives the value of an
/// earlier look (a sequence lock whose words are atomic).
template <class T>
class Mailbox {
  static_assert(std::is_trivially_copyable_v<T>);
  static constexpr std::size_t words = (sizeof(T) + 7) / 8;
  using Words = std::array<std::uint64_t, words>;

 public:
  /// By one thread.
  void put(const T& value) noexcept {
    Words raw{};
    std::memcpy(raw.data(), &value, sizeof value);
    const std::uint64_t n = puts_.load(std::memory_order_relaxed);
    puts_.store(n + 1, std::memory_order_relaxed);
    // Who sees one of the words sees that they are being written.
    for (std::size_t i = 0; i < words; ++i) raw_[i].store(raw[i], std::memory_order_release);
    puts_.store(n + 2, std::memory_order_release);
  }

  /// Copies the newest into `value`.
  /// @return false, and `value` stays, where nothing was put yet, or where each of 64 looks met a write
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

  /// Values put so far.
  std::uint64_t count() const noexcept { return puts_.load(std::memory_order_acquire) / 2; }

 private:
  std::atomic<std::uint64_t> puts_{0};  // odd while one is under way
  std::array<std::atomic<std::uint64_t>, words> raw_{};
};

}  // namespace sightline::dds
