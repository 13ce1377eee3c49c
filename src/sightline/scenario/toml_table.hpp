/// A TOML table with typed and range-checked access; every error states file, line, key, value and
/// expected value.
#pragma once

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/base/nearest.hpp"
#include "sightline/base/range.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// A key and the number it sets; without the key the number keeps its value.
struct NumberKey {
  std::string_view key;
  double* value;
  Range range = any_number();
};

/// A name in the file and the function that reads the part of that name.
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

/// One of the texts of a document.
struct TomlLayer {
  std::string name;  ///< the file; of a value set from outside "--set KEY=VALUE"
  std::string text;  ///< of a value set from outside: KEY=VALUE
  bool is_file = true;
};

/// A parsed file; owns the data of its tables.
struct TomlDocument {
  std::string file;
  toml::table root;
  std::string text{};
  std::vector<TomlLayer> layers{};  ///< from the lowest up; empty if its own text is the only one
  bool from_disk = true;            ///< files that it names are read from the disk; else they are in `files`
  mutable FileTexts files{};        ///< the requested ones
  const Registry* registry = nullptr;  ///< parts that it may name, must outlive it; null: those of sightline
};

/// @throws ScenarioError if check_text() rejects the text or it is not TOML
TomlDocument parse_toml(std::string_view text, std::string file);
/// The table alone; its nodes know the name of the file.
toml::table parse_layer(std::string_view text, const std::string& file);

/// Place of a key or a value in a document.
struct TomlPlace {
  const std::string& file;  ///< or the name of another layer
  std::size_t line;         ///< from 1; 0 in a layer that is not a file
};
TomlPlace place_of(const TomlDocument& document, const toml::source_region& source);
/// Whether `one` precedes `other`: in a lower layer, or earlier in the same.
bool stands_before(const TomlDocument& document, const toml::source_region& one,
                   const toml::source_region& other);

class TomlValue;

/// One table of a document. A view: the document must outlive it. Every reading function throws
/// ScenarioError.
class TomlTable {
 public:
  explicit TomlTable(const TomlDocument& document);
  /// The table of the document that has this path.
  TomlTable(const TomlDocument& document, const toml::table& table, std::string path);

  bool has(std::string_view key) const { return find(key) != nullptr; }
  std::size_t size() const { return table_->size(); }
  /// Its path in the file, `agent.uav0`.
  const std::string& path() const { return path_; }

  /// @throws ScenarioError for a key that is not in the list
  void expect_only(std::span<const std::string_view> known) const;
  void expect_only(std::initializer_list<std::string_view> known) const { expect_only(std::span(known)); }
  /// Reads numbers that have defaults; rejects keys that are neither in `fields` nor in `others`.
  void read(std::initializer_list<NumberKey> fields,
            std::initializer_list<std::string_view> others = {}) const;
  /// The only key of a table that selects one of several; the table may have `others` too.
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
  /// The same; `expected` describes the words.
  std::string_view word(std::string_view key, std::span<const std::string_view> known,
                        std::string_view expected) const;
  bool boolean(std::string_view key) const;
  Vec3<double> vec3(std::string_view key) const;
  /// An array of numbers, of this length, or of any length for `any_length`.
  std::vector<double> numbers(std::string_view key, std::size_t length,
                              const Range& range = any_number()) const;
  /// An array of times [s], each later than the previous one.
  std::vector<double> rising(std::string_view key) const;
  /// An array of `count` arrays of `length` numbers.
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t count, std::size_t length) const;
  std::vector<std::string> texts(std::string_view key, std::size_t length, std::string_view expected) const;

  /// The keys, in the order of the file.
  std::vector<std::string> keys() const;
  /// The value under the key, of any kind.
  TomlValue value(std::string_view key, std::string_view expected) const;

  TomlTable table(std::string_view key, std::string_view expected = "a table") const;
  /// The table, or an empty one if the key is missing.
  TomlTable table_or_empty(std::string_view key) const;
  /// The named tables within a table, in the order of the file.
  std::vector<std::pair<std::string, TomlTable>> named_tables(std::string_view key) const;
  /// The tables of [[key]].
  std::vector<TomlTable> tables(std::string_view key) const;

  /// Calls `make`, which makes an object of this table; a std::invalid_argument becomes a
  /// ScenarioError.
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
  /// An error of the table itself: `path = {...}, expected ...`.
  [[noreturn]] void throw_invalid(std::string_view expected) const;
  /// An error with this sentence. A sentence that begins with a key, or with `word.key`, gets the
  /// line of that key.
  [[noreturn]] void rethrow_at(std::string_view sentence) const;

  static constexpr std::size_t any_length = static_cast<std::size_t>(-1);

  /// The text of a file that this one names, relative to it. @throws ScenarioError as read_text()
  std::string file_text(const std::string& name) const;
  /// A text that `read` makes of a file that this one names, kept as that of the file `as`. A file
  /// `as` on the disk stands for the one that it was made of, if that is missing.
  std::string made_text(const std::string& name, const std::string& as,
                        const std::function<std::string(const std::filesystem::path&)>& read) const;
  /// The folder of such a file.
  std::filesystem::path file_folder(const std::string& name) const;
  /// Whether the files that it names must exist; those of a log's scenario may be missing.
  bool from_disk() const { return document_->from_disk; }
  /// The parts that it may name.
  const Registry& registry() const;
  /// The file, as in error messages.
  const std::string& file() const { return document_->file; }
  /// Place of its begin, `file:line`.
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

/// A value of any kind. A view, like a table.
class TomlValue {
 public:
  bool is_text() const { return node_->is_string(); }
  bool is_number() const { return node_->is_number(); }
  bool is_table() const { return node_->is_table(); }
  bool is_array() const { return node_->is_array(); }

  /// Each requires a value of that kind; the text is the parsed content.
  const std::string& text() const { return node_->as_string()->get(); }
  TomlTable table() const { return {*document_, *node_->as_table(), path_}; }
  /// The text, one of `known`; `expected` describes them.
  std::string_view word(std::span<const std::string_view> known, std::string_view expected) const;
  std::vector<TomlValue> items() const;
  double number(const Range& range = any_number()) const;

  /// `path = value, expected ...`.
  [[noreturn]] void throw_invalid(std::string_view expected) const;
  /// At the byte `offset` of a text, at the beginning of any other value: `file:line:column: path =
  /// value, sentence`.
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
