/// The kinds of a list, std::variant<...>, one after the other: what reads a scenario asks each what it is called.
#pragma once

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

namespace sightline {

/// Stands for a kind where there is none of it yet.
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

/// Whether a word is among those of a kind.
template <class Words>
bool contains(const Words& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace sightline
