#include "sightline/scenario/set_value.hpp"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string>
#include <system_error>
#include <variant>
#include <vector>

namespace sightline {
namespace {

using Step = std::variant<std::string, std::size_t>;  // a key of a table, a place in an array

[[noreturn]] void refuse(const TomlDocument& document, std::string_view assignment,
                         std::string_view expected) {
  throw ScenarioError(document.file, 0,
                      fmt::format("set {}, expected {}", shortened(assignment, 80), expected));
}

/// "agent.\"a b\".start.p[2]" step by step; none where it is no key.
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
      const std::size_t end = std::min(key.find_first_of(".[", at), key.size());
      name = key.substr(at, end - at);
      at = end;
    }
    if (name.empty()) return std::nullopt;
    steps.emplace_back(std::move(name));
  }
  return steps;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view space = " \t";
  const std::size_t from = text.find_first_not_of(space);
  return from == std::string_view::npos ? "" : text.substr(from, text.find_last_not_of(space) - from + 1);
}

}  // namespace

void set_value(TomlDocument& document, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const auto steps = steps_of(trimmed(assignment.substr(0, equals)));
  if (equals == std::string_view::npos || !steps) {
    refuse(document, assignment, "KEY=VALUE with a key as couple[0].weight");
  }
  const std::string value = fmt::format("value = {}", trimmed(assignment.substr(equals + 1)));
  toml::table parsed;
  try {
    check_text(value, document.file);
    parsed = toml::parse(value);
  } catch (const std::exception&) {  // of the text, or of TOML
    refuse(document, assignment, "a value as in TOML: a number, \"a text\", true, [an, array], { a = 1 }");
  }
  if (parsed.size() != 1 || !parsed.contains("value")) refuse(document, assignment, "one value");

  toml::node* node = &document.root;
  for (std::size_t i = 0; i < steps->size(); ++i) {
    const bool last = i + 1 == steps->size();
    if (const auto* place = std::get_if<std::size_t>(&(*steps)[i])) {
      toml::array* array = node->as_array();
      if (array == nullptr || *place >= array->size()) {
        refuse(document, assignment,
               array == nullptr ? std::string("a key that holds an array before [...]")
                                : fmt::format("a place in [0, {})", array->size()));
      }
      if (last) array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(*place), *parsed.get("value"));
      node = array->get(*place);
      continue;
    }
    toml::table* table = node->as_table();
    if (table == nullptr) refuse(document, assignment, "a key of a table");
    const auto& key = std::get<std::string>((*steps)[i]);
    if (last) table->insert_or_assign(key, *parsed.get("value"));
    if (!last && !table->contains(key)) table->insert(key, toml::table{});
    node = table->get(key);
  }
}

}  // namespace sightline
