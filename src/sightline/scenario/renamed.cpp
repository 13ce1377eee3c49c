#include "sightline/scenario/renamed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>

namespace sightline {
namespace {

constexpr std::array<std::string_view, 4> body_tables = {"agent", "target", "obstacle", "template"};

/// The tables that contain a key, from the root: ["agent", "uav1", "camera"]. Lists add no step.
using Steps = std::vector<std::string_view>;

bool is_body(const Steps& at) {
  return at.size() == 2 && std::find(body_tables.begin(), body_tables.end(), at[0]) != body_tables.end();
}
bool is_camera(const Steps& at) { return at.size() == 3 && at[2] == "camera"; }
bool is_log(const Steps& at) { return at.size() == 1 && at[0] == "log"; }
bool is_drawn(const Steps& at) { return !at.empty() && at[0] == "campaign"; }

struct OldKey {
  std::string_view old, present;
  bool (*stands_in)(const Steps&);
};
constexpr std::array<OldKey, 8> old_keys = {{{"watches", "observes", is_body},
                                             {"localized_by", "localization", is_body},
                                             {"like", "inherits", is_body},
                                             {"tells", "output", is_camera},
                                             {"paths", "prediction_period", is_log},
                                             {"exactly", "constant", is_drawn},
                                             {"share", "fraction", is_drawn},
                                             {"shares", "fractions", is_drawn}}};

/// A renamed value of a key.
struct OldWord {
  std::string_view key, old, present;
  bool (*stands_in)(const Steps&);
};
constexpr std::array<OldWord, 2> old_words = {
    {{"localization", "view", "vision", is_body}, {"localized_by", "view", "vision", is_body}}};

/// An old name and its place.
struct Found {
  std::string path;  ///< of the key
  std::string_view old, present;
  toml::source_region place;
  bool is_word = false;  ///< the name is the value of the key
};

void find_in(const toml::node& node, Steps& steps, const std::string& path,
             const std::function<void(const Found&)>& visit) {
  if (const toml::array* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i)
      find_in((*array)[i], steps, fmt::format("{}[{}]", path, i), visit);
    return;
  }
  const toml::table* table = node.as_table();
  if (table == nullptr) return;
  for (const auto& [key, inner] : *table) {
    const std::string here = path.empty() ? std::string(key.str()) : fmt::format("{}.{}", path, key.str());
    for (const OldKey& one : old_keys) {
      if (key.str() == one.old && one.stands_in(steps)) visit({here, one.old, one.present, key.source()});
    }
    const auto* word = inner.as_string();
    for (const OldWord& one : old_words) {
      if (word != nullptr && key.str() == one.key && word->get() == one.old && one.stands_in(steps))
        visit({here, one.old, one.present, inner.source(), true});
    }
    steps.push_back(key.str());
    find_in(inner, steps, here, visit);
    steps.pop_back();
  }
}

void find_old_names(const toml::table& root, const std::function<void(const Found&)>& visit) {
  Steps steps;
  find_in(root, steps, "", visit);
}

/// The byte at which a name begins, after its quote if it has one. Columns count characters.
std::optional<std::size_t> byte_of(std::string_view text, const toml::source_position& place,
                                   std::string_view name) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < place.line; ++line) {
    at = text.find('\n', at);
    if (at == text.npos) return {};
    ++at;
  }
  const auto continues = [&] {
    return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  for (toml::source_index column = 1; column < place.column && at < text.size(); ++column) {
    ++at;
    while (continues()) ++at;
  }
  if (at < text.size() && (text[at] == '"' || text[at] == '\'')) ++at;
  return text.substr(std::min(at, text.size())).starts_with(name) ? std::optional(at) : std::nullopt;
}

}  // namespace

void refuse_old_names(const TomlDocument& document) {
  // The first in the order of the file; the tables are sorted by their keys.
  std::optional<Found> first;
  find_old_names(document.root, [&](const Found& found) {
    if (!first || stands_before(document, found.place, first->place)) first = found;
  });
  if (!first) return;
  const TomlPlace at = place_of(document, first->place);
  const std::string where =
      first->is_word ? fmt::format("{} = \"{}\"", first->path, first->old) : first->path;
  const std::string expected =
      first->is_word ? fmt::format("\"{}\"", first->present) : fmt::format("the key {}", first->present);
  throw ScenarioError(
      at.file, at.line,
      fmt::format("{}, expected {}, its name since 0.2 (sightline check --fix rewrites a file)", where,
                  expected));
}

RenamedText with_present_names(std::string_view text, const std::string& file) {
  const toml::table root = parse_layer(text, file);
  std::vector<std::pair<std::size_t, Found>> all;
  find_old_names(root, [&](const Found& found) {
    if (const auto at = byte_of(text, found.place.begin, found.old)) all.emplace_back(*at, found);
  });
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  RenamedText renamed;
  std::size_t copied = 0;
  for (const auto& [at, found] : all) {
    renamed.text.append(text, copied, at - copied).append(found.present);
    copied = at + found.old.size();
    renamed.changes.push_back(
        found.is_word
            ? fmt::format("{}:{}: {} = \"{}\" is \"{}\" now", file, found.place.begin.line, found.path,
                          found.old, found.present)
            : fmt::format("{}:{}: {} is {} now", file, found.place.begin.line, found.path, found.present));
  }
  renamed.text.append(text, copied);
  return renamed;
}

}  // namespace sightline
