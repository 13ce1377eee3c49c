/// Iterates over the types of a list, std::variant<...>, for example to find the one that a key
/// names.
#pragma once

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

namespace sightline {

/// Represents a type without a value of it.
template <class K>
struct Kind {};

namespace detail {
template <class List>
struct Kinds;
template <class... K>
struct Kinds<std::variant<K...>> {
  template <class Each>
  static void visit(Each&& each) {
    (each(Kind<K>{}), ...);
  }
};
}  // namespace detail

/// Calls each(Kind<K>{}) for every kind K of the list.
template <class List, class Each>
void for_each_kind(Each&& each) {
  detail::Kinds<List>::visit(std::forward<Each>(each));
}

/// Whether a word is in a list of words.
template <class Words>
bool contains(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace sightline
