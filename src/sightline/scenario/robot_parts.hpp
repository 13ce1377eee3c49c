/// Robots of a scenario: by name, or as text.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "sightline/model/model.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// A name in the file and what reads the part of that name.
template <class Read>
struct Named {
  std::string_view name;
  Read read;
};

template <class Read, std::size_t n>
std::array<std::string_view, n> names(const std::array<Named<Read>, n>& list) {
  std::array<std::string_view, n> all;
  std::transform(list.begin(), list.end(), all.begin(), [](const auto& entry) { return entry.name; });
  return all;
}

template <class Read, std::size_t n>
Read find(const std::array<Named<Read>, n>& list, std::string_view name) {
  return std::find_if(list.begin(), list.end(), [&](const auto& entry) { return entry.name == name; })->read;
}

/// `robot` and `parameters` of [agent.NAME]. A robot is a name, or
/// `{ text = { states = [...], inputs = [...], f = { STATE = formula }, position = [...], heading = ... } }`.
Model read_robot(const TomlTable& agent);

}  // namespace sightline
