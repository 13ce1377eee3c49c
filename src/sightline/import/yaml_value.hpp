/// A YAML file with typed and range-checked access; every error states file, line, key, value and
/// expected value.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/base/range.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Largest size of a YAML or XML file that is imported [bytes], and the greatest depth of its nesting.
inline constexpr std::size_t import_size_max = 1'000'000;
inline constexpr int import_depth_max = 64;
/// Greatest number of entries of one mapping or sequence.
inline constexpr std::size_t import_entries_max = 4096;

/// The text of a file to import.
/// @throws ScenarioError for a file that cannot be read, is too large or is no text
std::string read_import_text(const std::filesystem::path& file);

/// A value of a YAML document. Every reading function throws ScenarioError.
class YamlValue {
 public:
  /// @throws ScenarioError for a text that is too large, too deep or no YAML
  YamlValue(std::string_view text, std::string file);
  // An assignment would change the tree, as yaml-cpp assigns nodes.
  YamlValue(const YamlValue&) = default;
  YamlValue& operator=(const YamlValue&) = delete;

  bool is_map() const { return node_.IsMap(); }
  bool is_sequence() const { return node_.IsSequence(); }
  bool is_scalar() const { return node_.IsScalar(); }

  /// The value under a key; none if the key is missing or without a value.
  std::optional<YamlValue> find(std::string_view key) const;
  /// The value under a path of keys, `a.b`; none if one is missing.
  std::optional<YamlValue> find_path(std::span<const std::string_view> keys) const;
  std::optional<YamlValue> find_path(std::initializer_list<std::string_view> keys) const {
    return find_path(std::span(keys.begin(), keys.size()));
  }
  /// The value under a key that must be given.
  YamlValue at(std::string_view key, std::string_view expected) const;
  /// The keys of a mapping with their values, in the order of the file; refuses a key that stands twice.
  std::vector<std::pair<std::string, YamlValue>> entries(std::string_view expected) const;
  /// The items of a sequence.
  std::vector<YamlValue> items(std::string_view expected) const;

  double number(const Range& range = any_number()) const;
  std::int64_t integer(std::int64_t low, std::int64_t high) const;
  bool boolean() const;
  /// A scalar of 1 to 128 bytes on one line.
  std::string text(std::string_view expected) const;
  /// A sequence of numbers, or a mapping with their sequence under `data`, as ROS and OpenCV write matrices.
  /// @param length  0: any
  std::vector<double> numbers(std::size_t length, const Range& range = any_number()) const;

  /// Its path in the file, `robots.cf1.type`.
  const std::string& path() const { return path_; }
  /// Line of its begin, from 1.
  std::size_t line() const;
  /// `file:line: path = value, expected ...`.
  [[noreturn]] void throw_invalid(std::string_view expected) const;

 private:
  YamlValue(const YamlValue& parent, YAML::Node node, const std::string& key);
  std::string value_text() const;

  std::shared_ptr<const std::string> file_;
  YAML::Node node_;
  std::string path_;
  std::size_t line_ = 1;  // of the key, for a value without a line of its own
};

}  // namespace sightline
