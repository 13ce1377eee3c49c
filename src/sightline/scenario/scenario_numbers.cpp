#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {
namespace {

/// Converts lines and columns (of characters, from 1) to bytes.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text), begins_{0} {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') begins_.push_back(i + 1);
    }
  }

  std::size_t offset(const toml::source_position& at) const {
    std::size_t i = begins_[at.line - 1];
    for (std::size_t column = 1; column < at.column && i < text_.size(); ++column) {
      do ++i;
      while (i < text_.size() && (static_cast<unsigned char>(text_[i]) & 0xc0U) == 0x80);
    }
    return i;
  }

 private:
  std::string_view text_;
  std::vector<std::size_t> begins_;
};

void collect(const toml::node& node, const std::string& key, const Lines& lines, ScenarioNumbers& numbers) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [name, inner] : *table) {
      collect(inner, key.empty() ? std::string(name.str()) : fmt::format("{}.{}", key, name.str()), lines,
              numbers);
    }
  } else if (const toml::array* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i)
      collect((*array)[i], fmt::format("{}[{}]", key, i), lines, numbers);
  } else if (node.is_number()) {
    const std::size_t begin = lines.offset(node.source().begin), end = lines.offset(node.source().end);
    numbers[key] = {begin, end - begin, *node.value<double>()};
  }
}

/// Offsets of the headers "[...]" of a table and of those in it.
void find_headers(const toml::node& node, std::string_view text, const Lines& lines,
                  std::vector<std::size_t>& headers) {
  if (const toml::table* table = node.as_table()) {
    if (table->source().begin) {
      const std::size_t begin = lines.offset(table->source().begin);
      if (begin < text.size() && text[begin] == '[') headers.push_back(begin);
    }
    for (const auto& [name, inner] : *table) find_headers(inner, text, lines, headers);
  } else if (const toml::array* array = node.as_array()) {
    for (const toml::node& item : *array) find_headers(item, text, lines, headers);
  }
}

}  // namespace

std::string with_spaces_for(std::string_view section, const TomlDocument& document) {
  std::string text = document.text;
  const toml::node* const its_node = document.root.get(section);
  if (its_node == nullptr) return text;
  const Lines lines(document.text);
  std::vector<std::size_t> all, its;
  find_headers(document.root, document.text, lines, all);
  find_headers(*its_node, document.text, lines, its);
  for (const std::size_t begin : its) {
    std::size_t end = text.size();
    for (const std::size_t other : all) {
      if (other > begin) end = std::min(end, other);
    }
    for (std::size_t i = begin; i < end; ++i) {
      if (text[i] != '\n') text[i] = ' ';
    }
  }
  return text;
}

ScenarioNumbers numbers_of(const TomlDocument& document) {
  ScenarioNumbers numbers;
  collect(document.root, "", Lines(document.text), numbers);
  return numbers;
}

std::string with_numbers(std::string_view text, std::span<const std::pair<NumberInText, double>> changes) {
  std::vector<std::pair<NumberInText, double>> sorted(changes.begin(), changes.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& a, const auto& b) { return a.first.offset < b.first.offset; });
  std::string result;
  std::size_t done = 0;
  for (const auto& [place, value] : sorted) {
    result += text.substr(done, place.offset - done);
    result += fmt::format("{}", value);
    done = place.offset + place.size;
  }
  return result += text.substr(done);
}

}  // namespace sightline
