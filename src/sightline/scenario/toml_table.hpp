/// A TOML table read with types and ranges; every refusal says file, line, key, value and what was expected.
#pragma once

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/base/nearest.hpp"
#include "sightline/base/range.hpp"
#include "sightline/scenario/scenario_text.hpp"

namespace sightline {

/// A key and the number it sets; without the key the number stays what it is.
struct NumberKey {
  std::string_view key;
  double* value;
  Range range = any_number();
};

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

struct Registry;

/// One of the texts that a document is made of.
struct TomlLayer {
  std::string name;  ///< the file; of a value that is set from outside "--set KEY=VALUE"
  std::string text;  ///< of that value KEY=VALUE
  bool is_file = true;
};

/// A parsed file, owner of what its tables look at.
struct TomlDocument {
  std::string file;
  toml::table root;
  std::string text{};
  std::vector<TomlLayer> layers{};  ///< from the lowest up, where it is more than its own text
  bool from_disk = true;      ///< files that it names are read from the disk; else they stand in `files`
  mutable FileTexts files{};  ///< those that were asked for
  const Registry* registry = nullptr;  ///< which it may call by name, outlive it; none: those of sightline
};

/// @throws ScenarioError where the text is refused by check_text() or is not TOML
TomlDocument parse_toml(std::string_view text, std::string file);
/// The table alone, whose nodes know the name of the file.
toml::table parse_layer(std::string_view text, const std::string& file);

/// Where a key or a value of a document stands.
struct TomlPlace {
  const std::string& file;  ///< or the name of another layer
  std::size_t line;         ///< from 1; 0 in a layer that is no file
};
TomlPlace place_of(const TomlDocument& document, const toml::source_region& source);
/// Whether one stands before the other: in a lower layer, or earlier in the same.
bool stands_before(const TomlDocument& document, const toml::source_region& one,
                   const toml::source_region& other);

class TomlValue;

/// One table of a document. A view: the document outlives it. Every reading function throws ScenarioError.
class TomlTable {
 public:
  explicit TomlTable(const TomlDocument& document);
  /// A table of the document, under this path.
  TomlTable(const TomlDocument& document, const toml::table& table, std::string path);

  bool has(std::string_view key) const { return find(key) != nullptr; }
  std::size_t size() const { return table_->size(); }
  /// Its place in the file, `agent.uav0`.
  const std::string& path() const { return path_; }

  /// Refuses keys that are not in the list.
  void expect_only(std::span<const std::string_view> known) const;
  void expect_only(std::initializer_list<std::string_view> known) const { expect_only(std::span(known)); }
  /// Reads numbers that have defaults; refuses keys that are neither in `fields` nor in `others`.
  void read(std::initializer_list<NumberKey> fields,
            std::initializer_list<std::string_view> others = {}) const;
  /// The only key of a table that chooses one of several; `others` may stand beside it.
  std::string_view choice(std::span<const std::string_view> known,
                          std::span<const std::string_view> others = {}) const;
  std::string_view choice(std::span<const std::string_view> known,
                          std::initializer_list<std::string_view> others) const {
    return choice(known, std::span(others));
  }

  double number(std::string_view key, const Range& range = any_number()) const;
  std::int64_t integer(std::string_view key, std::int64_t low, std::int64_t high) const;
  std::string text(std::string_view key, std::string_view expected) const;
  /// The text, one of `known`.
  std::string_view word(std::string_view key, std::span<const std::string_view> known) const;
  /// The same, where `expected` says what the words are.
  std::string_view word(std::string_view key, std::span<const std::string_view> known,
                        std::string_view expected) const;
  bool boolean(std::string_view key) const;
  Vec3<double> vec3(std::string_view key) const;
  /// An array of numbers; of this length, or of any where `length` is `any_length`.
  std::vector<double> numbers(std::string_view key, std::size_t length,
                              const Range& range = any_number()) const;
  /// An array of times [s], each later than the one before.
  std::vector<double> rising(std::string_view key) const;
  /// An array of `count` arrays of `length` numbers.
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t count, std::size_t length) const;
  std::vector<std::string> texts(std::string_view key, std::size_t length, std::string_view expected) const;

  /// The keys, in the order of the file.
  std::vector<std::string> keys() const;
  /// Whatever stands under the key.
  TomlValue value(std::string_view key, std::string_view expected) const;

  TomlTable table(std::string_view key, std::string_view expected = "a table") const;
  /// The table, or an empty one where the key is missing.
  TomlTable table_or_empty(std::string_view key) const;
  /// The named tables within a table, in the order of the file.
  std::vector<std::pair<std::string, TomlTable>> named_tables(std::string_view key) const;
  /// The tables of [[key]].
  std::vector<TomlTable> tables(std::string_view key) const;

  /// Makes something of this table; what it says of itself by std::invalid_argument becomes a ScenarioError.
  template <class Make>
  auto checked(Make&& make) const {
    try {
      return make();
    } catch (const std::invalid_argument& error) {
      rethrow_at(error.what());
    }
  }

  /// `path.key = value, expected ...`, or `path.key is missing, expected ...`.
  [[noreturn]] void throw_invalid(std::string_view key, std::string_view expected) const;
  /// `path.key[i] = value, expected ...`.
  [[noreturn]] void throw_invalid(std::string_view key, std::size_t i, std::string_view expected) const;
  /// Refuses the table itself, as `path = {...}, expected ...`.
  [[noreturn]] void throw_invalid(std::string_view expected) const;
  /// Refuses it with a sentence; one that begins with a key, or with `word.key`, at the line of that key.
  [[noreturn]] void rethrow_at(std::string_view sentence) const;

  static constexpr std::size_t any_length = static_cast<std::size_t>(-1);

  /// The text of a file that this one names, relative to it. @throws ScenarioError as read_text()
  std::string file_text(const std::string& name) const;
  /// The folder that such a file lies in.
  std::filesystem::path file_folder(const std::string& name) const;
  /// Whether files that it names are there; those of a log's scenario need not be any more.
  bool from_disk() const { return document_->from_disk; }
  /// What it may call by name.
  const Registry& registry() const;
  /// The file, as its refusals name it.
  const std::string& file() const { return document_->file; }
  /// Where it begins, `file:line`.
  std::string where() const;

 private:
  friend class TomlValue;

  const toml::node* find(std::string_view key) const;
  const toml::node& need(std::string_view key, std::string_view expected) const;
  const toml::array& array(std::string_view key, std::size_t length, std::string_view of) const;
  std::string place(std::string_view key) const;
  double number_at(const toml::node& node, const std::string& place, const Range& range) const;
  [[noreturn]] void refuse_node(const toml::node& node, std::string_view place,
                                std::string_view expected) const;

  const TomlDocument* document_;
  const toml::table* table_;
  std::string path_;
  toml::source_region source_{};
};

/// A value of any kind. A view, as a table is.
class TomlValue {
 public:
  bool is_text() const { return node_->is_string(); }
  bool is_number() const { return node_->is_number(); }
  bool is_table() const { return node_->is_table(); }
  bool is_array() const { return node_->is_array(); }

  /// Each for a value of that kind; the text as it is meant, not as it is written.
  const std::string& text() const { return node_->as_string()->get(); }
  TomlTable table() const { return {*document_, *node_->as_table(), path_}; }
  /// The text, one of `known`; `expected` says what they are.
  std::string_view word(std::span<const std::string_view> known, std::string_view expected) const;
  std::vector<TomlValue> items() const;
  double number(const Range& range = any_number()) const;

  /// `path = value, expected ...`.
  [[noreturn]] void throw_invalid(std::string_view expected) const;
  /// At the byte `offset` of a text, at the beginning of any other value: `file:line:column: path = value, sentence`.
  [[noreturn]] void refuse_at(std::size_t offset, std::string_view sentence) const;

 private:
  friend class TomlTable;
  TomlValue(const TomlDocument& document, const toml::node& node, std::string path)
      : document_(&document), node_(&node), path_(std::move(path)) {}

  const TomlDocument* document_;
  const toml::node* node_;
  std::string path_;
};

}  // namespace sightline
