/// List of measurements sorted by stamp, with a fixed capacity.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace sightline {

/// T has a `stamp` and a `source`, which orders equal stamps.
template <class T, std::size_t N>
class StampedList {
 public:
  const T* begin() const noexcept { return items_.data(); }
  const T* end() const noexcept { return items_.data() + size_; }
  bool empty() const noexcept { return size_ == 0; }
  bool is_full() const noexcept { return size_ == N; }
  void clear() noexcept { size_ = 0; }

  /// First item at or after a time.
  const T* from(double stamp) const noexcept {
    return std::lower_bound(begin(), end(), stamp, [](const T& a, double b) { return a.stamp < b; });
  }
  /// True if an item with this stamp and source is in the list.
  bool has(const T& item) const noexcept {
    const T* place = std::lower_bound(begin(), end(), item, before);
    return place != end() && !before(item, *place);
  }
  /// Requires room.
  void insert(const T& item) noexcept {
    T* const last = items_.data() + size_;
    T* const place = std::lower_bound(items_.data(), last, item, before);
    std::copy_backward(place, last, last + 1);
    *place = item;
    ++size_;
  }
  void drop_before(double stamp) noexcept {
    const T* const kept = from(stamp);
    const auto left = static_cast<std::size_t>(end() - kept);
    std::copy(kept, end(), items_.data());
    size_ = left;
  }

 private:
  static bool before(const T& a, const T& b) noexcept {
    return a.stamp != b.stamp ? a.stamp < b.stamp : a.source < b.source;
  }

  std::array<T, N> items_{};
  std::size_t size_ = 0;
};

}  // namespace sightline
