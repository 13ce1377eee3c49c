#include "sightline/scenario/layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>
#include <vector>

#include "sightline/scenario/renamed.hpp"
#include "sightline/scenario/set_value.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view based_on_key = "based_on";
// Of a region, of a MuJoCo model, of DDS keys.
constexpr std::array<std::string_view, 3> file_keys = {"file", "model", "folder"};

bool is_section_table(const toml::node& node) { return node.is_table() && !node.as_table()->is_inline(); }

bool goes_on(const toml::node& node) {
  const toml::array* list = node.as_array();
  return list != nullptr && !list->empty() && std::all_of(list->begin(), list->end(), is_section_table);
}

/// Merges the upper table into a table.
void put_over(toml::table& into, toml::table&& upper) {
  for (auto&& [key, node] : upper) {
    toml::node* below = into.get(key.str());
    if (below != nullptr && below->is_table() && is_section_table(node)) {
      put_over(*below->as_table(), std::move(*node.as_table()));
    } else if (below != nullptr && below->is_array() && goes_on(node)) {
      for (toml::node& item : *node.as_array()) below->as_array()->push_back(std::move(item));
    } else {
      into.insert_or_assign(toml::key(key), std::move(node));
    }
  }
}

/// Changes the names of files to be relative to the parent of `folder`.
/// @return whether there are any
bool name_files_from(toml::node& node, const fs::path& folder) {
  bool named = false;
  if (toml::table* table = node.as_table()) {
    for (auto&& [key, inner] : *table) {
      auto* name = inner.as_string();
      if (name != nullptr && std::find(file_keys.begin(), file_keys.end(), key.str()) != file_keys.end()) {
        name->get() = (folder / name->get()).lexically_normal().native();
        named = true;
      } else {
        named |= name_files_from(inner, folder);
      }
    }
  } else if (toml::array* array = node.as_array()) {
    for (toml::node& item : *array) named |= name_files_from(item, folder);
  }
  return named;
}

/// Appends the file's text to the layers, after those of its base files.
void stack(std::string_view text, const std::string& file, std::vector<fs::path> above,
           std::vector<TomlLayer>& layers) {
  const toml::table root = parse_layer(text, file);
  if (const toml::node* based_on = root.get(based_on_key)) {
    const auto throw_invalid = [&](std::string_view value, std::string_view expected) {
      throw ScenarioError(file, based_on->source().begin.line,
                          fmt::format("{} = {}, expected a scenario file, relative to this one{}",
                                      based_on_key, value, expected));
    };
    const auto* name = based_on->as_string();
    if (name == nullptr) throw_invalid("...", "");
    const std::string shown = fmt::format("\"{}\"", shortened(name->get(), shown_size));
    const fs::path below = (fs::path(file).parent_path() / name->get()).lexically_normal();
    above.push_back(fs::weakly_canonical(file));
    if (std::find(above.begin(), above.end(), fs::weakly_canonical(below)) != above.end())
      throw_invalid(shown, " and not based on itself");
    std::string of_below;
    try {
      of_below = read_text(below);
    } catch (const ScenarioError& error) {
      throw_invalid(shown, fmt::format(" ({})", error.what()));
    }
    stack(of_below, below.native(), above, layers);
  }
  layers.push_back({file, std::string(text)});
}

toml::table root_of(const TomlDocument& document) {
  toml::table root;
  for (const TomlLayer& layer : document.layers) {
    if (!layer.is_file) {
      set_value(root, layer);
      continue;
    }
    toml::table upper = parse_layer(layer.text, layer.name);
    upper.erase(based_on_key);
    const fs::path folder = fs::path(layer.name)
                                .lexically_normal()
                                .parent_path()
                                .lexically_relative(fs::path(document.file).lexically_normal().parent_path());
    if (folder != "." && !folder.empty()) (void)name_files_from(upper, folder);
    put_over(root, std::move(upper));
  }
  return root;
}

}  // namespace

TomlDocument layered(std::string_view text, std::string file, std::span<const std::string> set) {
  TomlDocument document = parse_toml(text, std::move(file));
  if (!set.empty() || document.root.contains(based_on_key)) {
    stack(text, document.file, {}, document.layers);
    for (const std::string& assignment : set) document.layers.push_back(set_layer(assignment));
    document.root = root_of(document);
  }
  refuse_old_names(document);
  return document;
}

TomlDocument as_written(const TomlDocument& document) {
  if (document.layers.empty()) return parse_toml(document.text, document.file);
  return {document.file, root_of(document), document.text, document.layers};
}

std::string text_seen_from(const fs::path& folder, const std::string& text, const fs::path& file) {
  TomlDocument document = parse_toml(text, file.native());
  const fs::path there = file.has_parent_path() ? file.parent_path() : ".";
  return name_files_from(document.root, fs::relative(there, folder)) ? printed(document) : text;
}

}  // namespace sightline
