/// A list of at most N items, stored in place. It never allocates, and constructs only the items
/// added.
#pragma once

#include <cassert>
#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace sightline {

template <class T, std::size_t N>
class Bounded {
  static_assert(std::is_trivially_destructible_v<T> && std::is_trivially_copyable_v<T>);

 public:
  Bounded() noexcept {}

  T& push_back(const T& item) noexcept {
    assert(size_ < N && "the items fit the list");
    return *std::construct_at(&items_[size_++], item);
  }
  /// Value-initialises an item in place: zeros, or the item's own defaults.
  T& emplace_back() noexcept {
    assert(size_ < N && "the items fit the list");
    return *std::construct_at(&items_[size_++]);
  }
  void clear() noexcept { size_ = 0; }

  std::size_t size() const noexcept { return size_; }
  bool empty() const noexcept { return size_ == 0; }
  bool is_full() const noexcept { return size_ == N; }
  T& operator[](std::size_t i) noexcept { return items_[i]; }
  const T& operator[](std::size_t i) const noexcept { return items_[i]; }
  std::span<const T> items() const noexcept { return {items_, size_}; }
  T* begin() noexcept { return items_; }
  T* end() noexcept { return items_ + size_; }
  const T* begin() const noexcept { return items_; }
  const T* end() const noexcept { return items_ + size_; }

 private:
  union {
    T items_[N];
  };
  std::size_t size_ = 0;
};

}  // namespace sightline
