#include "sightline/scenario/set_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/base/character.hpp"

namespace sightline {
namespace {

constexpr std::string_view around_words = " \t";

using Step = std::variant<std::string, std::size_t>;  // a key of a table, an index of an array

[[noreturn]] void refuse_layer(const TomlLayer& layer, std::string_view expected) {
  throw ScenarioError(layer.name, 0, fmt::format("expected {}", expected));
}

/// The steps of "agent.\"a b\".start.p[2]"; none if it is not a key.
std::optional<std::vector<Step>> steps_of(std::string_view key) {
  std::vector<Step> steps;
  std::size_t at = 0;
  for (bool first = true; first || at < key.size(); first = false) {
    if (!first && key[at] == '[') {
      std::size_t place = 0;
      const auto [next, fault] = std::from_chars(key.data() + at + 1, key.data() + key.size(), place);
      const auto end = static_cast<std::size_t>(next - key.data());
      if (fault != std::errc() || end >= key.size() || key[end] != ']') return std::nullopt;
      steps.emplace_back(place);
      at = end + 1;
      continue;
    }
    if (!first && key[at++] != '.') return std::nullopt;
    std::string name;
    if (at < key.size() && key[at] == '"') {
      const std::size_t end = key.find('"', at + 1);
      if (end == std::string_view::npos) return std::nullopt;
      name = key.substr(at + 1, end - at - 1);
      at = end + 1;
    } else {
      std::size_t end = key.find_first_of(".[{", at);
      if (end < key.size() && key[end] == '{') end = key.find_first_of(".[", key.find('}', end));  // a range
      end = std::min(end, key.size());
      name = key.substr(at, end - at);
      at = end;
    }
    if (name.empty()) return std::nullopt;
    steps.emplace_back(std::move(name));
  }
  return steps;
}

/// The value in a table of its own, which keeps the value's source.
std::optional<toml::table> value_of(std::string_view text, const TomlLayer& layer) {
  try {
    toml::table parsed = parse_layer(fmt::format("value = {}", text), layer.name);
    if (parsed.size() == 1 && parsed.contains("value")) return parsed;
  } catch (const ScenarioError&) {  // the caller reports the error
  }
  return std::nullopt;
}

bool is_bare_word(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto may_follow = [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') ||
           std::string_view("_-./").find(c) != std::string_view::npos;
  };
  return !text.empty() && is_letter(text[0]) && std::all_of(text.begin(), text.end(), may_follow);
}

}  // namespace

std::string assignment(std::string_view key, double value) {
  if (key.find('=') != std::string_view::npos || !steps_of(trimmed(key, around_words)))
    throw_invalid("{}, expected a key as couple[0].weight", one_line(shortened(key, shown_size)));
  return fmt::format("{}={}", key, value);
}

TomlLayer set_layer(std::string_view assignment) {
  return {"--set " + shortened(assignment, 80), std::string(assignment), false};
}

void set_value(toml::table& root, const TomlLayer& layer) {
  const std::string_view assignment = layer.text;
  const std::size_t equals = assignment.find('=');
  const auto steps = steps_of(trimmed(assignment.substr(0, equals), around_words));
  if (equals == std::string_view::npos || !steps)
    refuse_layer(layer, "KEY=VALUE with a key as couple[0].weight");
  const std::string_view text = trimmed(assignment.substr(equals + 1), around_words);
  std::optional<toml::table> parsed = value_of(text, layer);
  if (!parsed && is_bare_word(text)) parsed = value_of(fmt::format("\"{}\"", text), layer);
  if (!parsed)
    refuse_layer(layer, "one value as in TOML: a number, \"a text\", true, [an, array], { a = 1 }");
  const toml::source_region place = parsed->get("value")->source();

  toml::node* node = &root;
  for (std::size_t i = 0; i < steps->size(); ++i) {
    const bool last = i + 1 == steps->size();
    if (const auto* index = std::get_if<std::size_t>(&(*steps)[i])) {
      toml::array* array = node->as_array();
      if (array == nullptr) refuse_layer(layer, "a key that holds an array before [...]");
      if (*index >= array->size()) refuse_layer(layer, fmt::format("a place in [0, {})", array->size()));
      if (last)
        array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(*index),
                       std::move(*parsed->get("value")));
      node = array->get(*index);
      continue;
    }
    toml::table* table = node->as_table();
    if (table == nullptr) refuse_layer(layer, "a key of a table");
    const toml::key key(std::get<std::string>((*steps)[i]), toml::source_region(place));
    if (last) {
      table->insert_or_assign(key, std::move(*parsed->get("value")));
    } else if (!table->contains(key.str())) {
      toml::table section = std::move(*value_of("{}", layer)->get("value")->as_table());
      section.is_inline(false);
      table->insert(key, std::move(section));
    }
    node = table->get(key.str());
  }
}

}  // namespace sightline
