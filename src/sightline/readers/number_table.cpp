#include "sightline/readers/number_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "sightline/base/character.hpp"

namespace sightline {
namespace {

constexpr std::string_view blanks = " \t\r\v\f", around = " \t\r\v\f\"", marks = ",;";
constexpr std::size_t shown_max = 40;

}  // namespace

std::optional<double> finite_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::string printable(std::string_view field) {
  std::string shown(field.substr(0, shown_max));
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return shown + (field.size() > shown_max ? "..." : "");
}

NumberTable::NumberTable(std::string file, std::string_view text) : file_(std::move(file)), rest_(text) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (rest_.starts_with(byte_order_mark)) rest_.remove_prefix(byte_order_mark.size());
}

bool NumberTable::next_or_remark() {
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view row = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_;
    row.remove_prefix(std::min(row.find_first_not_of(blanks), row.size()));
    is_remark_ = row.starts_with('#');
    if (is_remark_) row.remove_prefix(1);
    const bool spaced = row.find_first_of(marks) == std::string_view::npos;
    bool empty = true;
    fields_.clear();
    for (std::size_t at = 0; at <= row.size();) {
      const std::size_t to = std::min(row.find_first_of(spaced ? blanks : marks, at), row.size());
      const std::string_view field = trimmed(row.substr(at, to - at), around);
      empty = empty && field.empty();
      if (!spaced || !field.empty()) fields_.push_back(field);
      at = to + 1;
    }
    if (!empty) return true;
  }
  return false;
}

bool NumberTable::next() {
  while (next_or_remark()) {
    if (!is_remark_) return true;
  }
  return false;
}

double NumberTable::number(std::size_t field, const NumberColumn& column) const {
  const std::string_view text = fields_[field];
  const std::optional<double> value = finite_number(text);
  if (!value) refuse(fmt::format("{} = {}, expected a number", column.name, printable(text)));
  if (!column.bounds.hold(*value))
    refuse(fmt::format("{} = {}, expected {}", column.name, printable(text),
                       column.bounds.expected(column.unit)));
  return *value;
}

std::vector<double> NumberTable::numbers(std::span<const NumberColumn> columns) const {
  if (fields_.size() != columns.size()) {
    std::string names;
    for (const NumberColumn& column : columns) names.append(names.empty() ? "" : ", ").append(column.name);
    refuse(fmt::format("{} fields, expected {}: {}", fields_.size(), columns.size(), names));
  }
  std::vector<double> row;
  for (std::size_t i = 0; i < columns.size(); ++i) row.push_back(number(i, columns[i]));
  return row;
}

void NumberTable::refuse(const std::string& sentence) const {
  throw std::invalid_argument(fmt::format("{}:{}: {}", file_, line_, sentence));
}

}  // namespace sightline
