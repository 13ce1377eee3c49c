#include "sightline/scenario/toml_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "sightline/registry.hpp"
#include "sightline/scenario/file_kind.hpp"
#include "sightline/scenario/string_place.hpp"

namespace sightline {
namespace {

/// In quotes, with inner quotes escaped.
std::string in_toml_quotes(std::string_view text) {
  std::string all = "\"";
  for (const char c : text) {
    if (c == '"') all += '\\';
    all += c;
  }
  return all += '"';
}

std::string shown_key(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? shortened(key, shown_size) : in_toml_quotes(shortened(key, shown_size));
}

/// A value in the short form of an error message.
std::string shown(const toml::node& node) {
  if (const auto* v = node.as_integer()) return fmt::format("{}", v->get());
  if (const auto* v = node.as_floating_point()) return fmt::format("{}", v->get());
  if (const auto* v = node.as_boolean()) return v->get() ? "true" : "false";
  if (const auto* v = node.as_string()) return in_toml_quotes(shortened(v->get(), shown_size));
  if (const auto* table = node.as_table()) return table->empty() ? "{}" : "{...}";
  const toml::array* array = node.as_array();
  if (array == nullptr) return "a date or time";
  std::string list;
  for (const toml::node& entry : *array) {
    if (!list.empty()) list += ", ";
    list += entry.is_array() ? "[...]" : shown(entry);
    if (list.size() > shown_size) return fmt::format("[{}]", shortened(list, shown_size));
  }
  return fmt::format("[{}]", list);
}

/// Whether U+0000 may be in a string; as a character of its own TOML has none.
bool has_null_escape(std::string_view text) {
  return text.find("\\u0000") != text.npos || text.find("\\U00000000") != text.npos;
}

/// Rejects U+0000: texts are names, paths or formulas, and the system's strings end there.
void refuse_null_characters(const toml::node& node, const std::string& key, const std::string& file) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [name, inner] : *table)
      refuse_null_characters(inner, key.empty() ? shown_key(name.str()) : key + '.' + shown_key(name.str()),
                             file);
  } else if (const toml::array* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i)
      refuse_null_characters((*array)[i], fmt::format("{}[{}]", key, i), file);
  } else if (const auto* text = node.as_string();
             text != nullptr && text->get().find('\0') != std::string::npos) {
    throw ScenarioError(file, node.source().begin.line,
                        fmt::format("{} = {}, expected a text without U+0000", key, shown(node)));
  }
}

/// Index of the layer of a place, from the lowest; 0 without layers.
std::size_t layer_of(const TomlDocument& document, const toml::source_region& source) {
  if (document.layers.empty() || !source.path) return 0;
  const auto is = [&](const TomlLayer& layer) { return layer.name == *source.path; };
  return static_cast<std::size_t>(std::find_if(document.layers.begin(), document.layers.end() - 1, is) -
                                  document.layers.begin());
}

/// Source of a value in a table. A value that replaced another has no line of its own and takes the
/// table's.
const toml::source_region& region_of(const toml::node& node, const toml::source_region& table) {
  return node.source().begin.line > 0 ? node.source() : table;
}

/// Throws the sentence with its place in the document.
[[noreturn]] void refuse_at_place(const TomlDocument& document, const toml::source_region& source,
                                  std::string_view sentence) {
  const TomlPlace at = place_of(document, source);
  throw ScenarioError(at.file, at.line, sentence);
}

}  // namespace

TomlPlace place_of(const TomlDocument& document, const toml::source_region& source) {
  const std::size_t line = std::max<std::size_t>(source.begin.line, 1);
  if (document.layers.empty() || !source.path) return {document.file, line};
  const TomlLayer& layer = document.layers[layer_of(document, source)];
  return {layer.name, layer.is_file ? line : 0};
}

bool stands_before(const TomlDocument& document, const toml::source_region& one,
                   const toml::source_region& other) {
  const std::size_t a = layer_of(document, one), b = layer_of(document, other);
  return a != b ? a < b : one.begin < other.begin;
}

TomlDocument parse_toml(std::string_view text, std::string file) {
  toml::table root = parse_layer(text, file);
  return {std::move(file), std::move(root), std::string(text)};
}

toml::table parse_layer(std::string_view text, const std::string& file) {
  const FileKind kind = file_kind(text.substr(0, file_head));
  if (!kind.what.empty() && !kind.is_text) throw ScenarioError(file, 1, kind_sentence(kind));
  check_text(text, file);
  try {
    toml::table root = toml::parse(text, file);
    if (has_null_escape(text)) refuse_null_characters(root, "", file);
    return root;
  } catch (const toml::parse_error& error) {
    if (!kind.what.empty()) throw ScenarioError(file, 1, kind_sentence(kind));
    throw ScenarioError(file, std::max<std::size_t>(error.source().begin.line, 1),
                        fmt::format("{}, expected TOML", shortened(error.description(), 4 * shown_size)));
  }
}

TomlTable::TomlTable(const TomlDocument& document) : document_(&document), table_(&document.root) {}

TomlTable::TomlTable(const TomlDocument& document, const toml::table& table, std::string path)
    : document_(&document), table_(&table), path_(std::move(path)), source_(table.source()) {}

std::string TomlTable::where() const {
  const TomlPlace at = place_of(*document_, source_);
  return at.line > 0 ? fmt::format("{}:{}", at.file, at.line) : at.file;
}

const Registry& TomlTable::registry() const {
  return document_->registry != nullptr ? *document_->registry : built_in_registry();
}

const toml::node* TomlTable::find(std::string_view key) const { return table_->get(key); }

const toml::node& TomlTable::need(std::string_view key, std::string_view expected) const {
  const toml::node* node = find(key);
  if (node == nullptr) throw_invalid(key, expected);
  return *node;
}

std::string TomlTable::place(std::string_view key) const {
  return path_.empty() ? shown_key(key) : fmt::format("{}.{}", path_, shown_key(key));
}

std::string TomlTable::file_text(const std::string& name) const { return made_text(name, name, read_text); }

std::string TomlTable::made_text(const std::string& name, const std::string& as,
                                 const std::function<std::string(const std::filesystem::path&)>& read) const {
  const auto known = document_->files.find(as);
  if (known != document_->files.end()) return known->second;
  const std::filesystem::path folder = std::filesystem::path(file()).parent_path(), path = folder / name,
                              made = folder / as;
  if (!document_->from_disk)
    throw ScenarioError(path.native(), 1, "its text is missing, expected it with the scenario's");
  std::error_code ignored;
  const bool is_made = !std::filesystem::exists(path, ignored) && std::filesystem::exists(made, ignored);
  return document_->files[as] = is_made ? read_text(made) : read(path);
}

std::filesystem::path TomlTable::file_folder(const std::string& name) const {
  return (std::filesystem::path(file()).parent_path() / name).parent_path();
}

void TomlTable::expect_only(std::span<const std::string_view> known) const {
  for (const auto& [key, node] : *table_) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    const std::string expected = known.empty()
                                     ? std::string("no key here")
                                     : "a known key" + hint(shortened(key.str(), shown_size), known);
    refuse_at_place(*document_, key.source(),
                    fmt::format("{} = {}, expected {}", place(key.str()), shown(node), expected));
  }
}

void TomlTable::read(std::initializer_list<NumberKey> fields,
                     std::initializer_list<std::string_view> others) const {
  std::vector<std::string_view> known(others);
  for (const NumberKey& field : fields) known.push_back(field.key);
  expect_only(known);
  for (const NumberKey& field : fields) {
    if (has(field.key)) *field.value = number(field.key, field.range);
  }
}

std::string_view TomlTable::choice(std::span<const std::string_view> known,
                                   std::span<const std::string_view> others) const {
  std::vector<std::string_view> all(known.begin(), known.end());
  all.insert(all.end(), others.begin(), others.end());
  expect_only(all);
  const auto has_key = [&](std::string_view key) { return has(key); };
  if (std::count_if(known.begin(), known.end(), has_key) != 1) {
    throw_invalid(fmt::format("exactly one of {}", fmt::join(known, ", ")));
  }
  return *std::find_if(known.begin(), known.end(), has_key);
}

double TomlTable::number_at(const toml::node& node, const std::string& at, const Range& range) const {
  const bool is_number = node.is_floating_point() || node.is_integer();
  const double value = is_number ? *node.value<double>() : 0.0;
  if (!is_number) refuse_node(node, at, fmt::format("a number, {}", range.expected));
  if (!range.holds(value)) refuse_node(node, at, range.expected_of(value));
  return value;
}

double TomlTable::number(std::string_view key, const Range& range) const {
  return number_at(need(key, fmt::format("a number, {}", range.expected)), place(key), range);
}

std::int64_t TomlTable::integer(std::string_view key, std::int64_t low, std::int64_t high) const {
  const std::string expected = fmt::format("an integer, {} to {}", low, high);
  const toml::node& node = need(key, expected);
  const auto* value = node.as_integer();
  if (const auto* real = node.as_floating_point();
      real != nullptr && std::abs(real->get()) < 1e15 && real->get() == std::floor(real->get())) {
    refuse_at_place(
        *document_, region_of(node, source_),
        fmt::format("{} = {:.1f}, expected {}, without a point", place(key), real->get(), expected));
  }
  if (value == nullptr || value->get() < low || value->get() > high) refuse_node(node, place(key), expected);
  return value->get();
}

std::string TomlTable::text(std::string_view key, std::string_view expected) const {
  const toml::node& node = need(key, expected);
  const auto* value = node.as_string();
  if (value == nullptr) refuse_node(node, place(key), expected);
  return value->get();
}

std::string_view TomlTable::word(std::string_view key, std::span<const std::string_view> known) const {
  const std::string expected = fmt::format("one of \"{}\"", fmt::join(known, "\", \""));
  const TomlValue given = value(key, expected);
  if (!given.is_text()) given.throw_invalid(expected);
  const auto found = std::find(known.begin(), known.end(), given.text());
  if (found != known.end()) return *found;
  const auto near = nearest(shortened(given.text(), shown_size), known);
  given.throw_invalid(near ? fmt::format("{}, the nearest is \"{}\"", expected, *near) : expected);
}

std::string_view TomlTable::word(std::string_view key, std::span<const std::string_view> known,
                                 std::string_view expected) const {
  return value(key, expected).word(known, expected);
}

bool TomlTable::boolean(std::string_view key) const {
  constexpr std::string_view expected = "true or false";
  const auto* value = need(key, expected).as_boolean();
  if (value == nullptr) throw_invalid(key, expected);
  return value->get();
}

const toml::array& TomlTable::array(std::string_view key, std::size_t length, std::string_view of) const {
  const std::string count = length == any_length ? std::string("one or more") : fmt::format("{}", length);
  const std::string expected = fmt::format("an array of {} {}", count, of);
  const toml::node& node = need(key, expected);
  const toml::array* entries = node.as_array();
  if (entries == nullptr || entries->empty() || (length != any_length && entries->size() != length)) {
    refuse_node(node, place(key), expected);
  }
  return *entries;
}

std::vector<double> TomlTable::numbers(std::string_view key, std::size_t length, const Range& range) const {
  const toml::array& entries = array(key, length, "numbers");
  std::vector<double> values;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    values.push_back(number_at(entries[i], fmt::format("{}[{}]", place(key), i), range));
  }
  return values;
}

Vec3<double> TomlTable::vec3(std::string_view key) const {
  const std::vector<double> v = numbers(key, 3);
  return {v[0], v[1], v[2]};
}

std::vector<double> TomlTable::rising(std::string_view key) const {
  std::vector<double> times = numbers(key, any_length);
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (!(times[i] > times[i - 1])) throw_invalid(key, i, "times that rise [s]");
  }
  return times;
}

std::vector<std::vector<double>> TomlTable::rows(std::string_view key, std::size_t count,
                                                 std::size_t length) const {
  const toml::array& entries = array(key, count, fmt::format("arrays of {} numbers", length));
  std::vector<std::vector<double>> values;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::string at = fmt::format("{}[{}]", place(key), i);
    const toml::array* row = entries[i].as_array();
    if (row == nullptr || row->size() != length)
      refuse_node(entries[i], at, fmt::format("an array of {} numbers", length));
    std::vector<double>& to = values.emplace_back();
    for (std::size_t j = 0; j < length; ++j) {
      to.push_back(number_at((*row)[j], fmt::format("{}[{}]", at, j), any_number()));
    }
  }
  return values;
}

std::vector<std::string> TomlTable::texts(std::string_view key, std::size_t length,
                                          std::string_view expected) const {
  const toml::array& entries = array(key, length, expected);
  std::vector<std::string> values;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto* value = entries[i].as_string();
    if (value == nullptr) throw_invalid(key, i, "a name in quotes");
    values.push_back(value->get());
  }
  return values;
}

TomlTable TomlTable::table(std::string_view key, std::string_view expected) const {
  const toml::node& node = need(key, expected);
  const toml::table* inner = node.as_table();
  if (inner == nullptr) refuse_node(node, place(key), expected);
  return TomlTable(*document_, *inner, place(key));
}

TomlTable TomlTable::table_or_empty(std::string_view key) const {
  if (has(key)) return table(key);
  static const toml::table empty;
  TomlTable inner(*document_, empty, place(key));
  inner.source_ = source_;
  return inner;
}

std::vector<std::pair<std::string, TomlTable>> TomlTable::named_tables(std::string_view key) const {
  if (!has(key)) return {};
  const TomlTable inner = table(key);
  std::vector<std::pair<std::string, TomlTable>> list;
  for (const std::string& name : inner.keys()) list.emplace_back(name, inner.table(name));
  return list;
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  const toml::node* node = find(key);
  if (node == nullptr) return {};
  const toml::array* entries = node->as_array();
  const std::string expected = fmt::format("tables under [[{}]]", key);
  if (entries == nullptr) throw_invalid(key, expected);
  std::vector<TomlTable> list;
  for (std::size_t i = 0; i < entries->size(); ++i) {
    const toml::table* inner = (*entries)[i].as_table();
    if (inner == nullptr) throw_invalid(key, i, expected);
    list.push_back(TomlTable(*document_, *inner, fmt::format("{}[{}]", place(key), i)));
  }
  return list;
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<const toml::key*> keys;
  for (const auto& entry : *table_) keys.push_back(&entry.first);
  std::sort(keys.begin(), keys.end(), [this](const toml::key* a, const toml::key* b) {
    return stands_before(*document_, a->source(), b->source());
  });
  std::vector<std::string> list;
  for (const toml::key* k : keys) list.emplace_back(k->str());
  return list;
}

TomlValue TomlTable::value(std::string_view key, std::string_view expected) const {
  return {*document_, need(key, expected), place(key)};
}

std::string_view TomlValue::word(std::span<const std::string_view> known, std::string_view expected) const {
  if (!is_text()) throw_invalid(expected);
  const auto found = std::find(known.begin(), known.end(), text());
  if (found != known.end()) return *found;
  if (known.empty()) throw_invalid(fmt::format("{}, there is none", expected));
  throw_invalid(fmt::format("{}{}", expected, hint(shortened(text(), shown_size), known)));
}

std::vector<TomlValue> TomlValue::items() const {
  std::vector<TomlValue> list;
  for (const toml::node& node : *node_->as_array()) {
    list.push_back(TomlValue(*document_, node, fmt::format("{}[{}]", path_, list.size())));
  }
  return list;
}

double TomlValue::number(const Range& range) const {
  const double value = *node_->value<double>();
  if (!range.holds(value)) throw_invalid(range.expected_of(value));
  return value;
}

void TomlValue::throw_invalid(std::string_view expected) const {
  refuse_at_place(*document_, node_->source(),
                  fmt::format("{} = {}, expected {}", path_, shown(*node_), expected));
}

void TomlValue::refuse_at(std::size_t offset, std::string_view sentence) const {
  const toml::source_region& source = node_->source();
  const std::string message = fmt::format("{} = {}, {}", path_, shown(*node_), sentence);
  const TomlPlace at = place_of(*document_, source);
  if (at.line == 0) refuse_at_place(*document_, source, message);
  const std::string& file_text =
      document_->layers.empty() ? document_->text : document_->layers[layer_of(*document_, source)].text;
  const TextPlace place = place_in_string(file_text, {source.begin.line, source.begin.column},
                                          is_text() ? text() : std::string_view(), offset);
  throw ScenarioError(at.file, place.line, place.column, message);
}

void TomlTable::refuse_node(const toml::node& node, std::string_view at, std::string_view expected) const {
  refuse_at_place(*document_, region_of(node, source_),
                  fmt::format("{} = {}, expected {}", at, shown(node), expected));
}

void TomlTable::throw_invalid(std::string_view key, std::string_view expected) const {
  if (const toml::node* node = find(key)) refuse_node(*node, place(key), expected);
  refuse_at_place(*document_, source_, fmt::format("{} is missing, expected {}", place(key), expected));
}

void TomlTable::throw_invalid(std::string_view key, std::size_t i, std::string_view expected) const {
  refuse_node((*find(key)->as_array())[i], fmt::format("{}[{}]", place(key), i), expected);
}

void TomlTable::throw_invalid(std::string_view expected) const {
  refuse_at_place(*document_, source_, fmt::format("{} = {}, expected {}", path_, shown(*table_), expected));
}

void TomlTable::rethrow_at(std::string_view sentence) const {
  // Prefers the line of the key to that of the table.
  const std::size_t dot = sentence.find('.'), equals = sentence.find(" = ");
  if (equals != std::string_view::npos) {
    const std::size_t begin = dot < equals ? dot + 1 : 0;
    const std::string_view key = sentence.substr(begin, equals - begin);
    if (const toml::node* node = find(key)) {
      refuse_at_place(*document_, node->source(), fmt::format("{}{}", place(key), sentence.substr(equals)));
    }
  }
  refuse_at_place(*document_, source_, fmt::format("{}: {}", path_, sentence));
}

}  // namespace sightline
