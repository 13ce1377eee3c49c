#include "sightline/analysis/localization/number_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace sightline {
namespace {

constexpr std::string_view blanks = " \t\r\v\f";
constexpr std::size_t shown_max = 40;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

/// A field as it is shown in a message: printable, and not too long.
std::string printable(std::string_view field) {
  std::string shown(field.substr(0, shown_max));
  std::replace_if(
      shown.begin(), shown.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, '?');
  return shown + (field.size() > shown_max ? "..." : "");
}

}  // namespace

bool NumberTable::next() {
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view row = trimmed(rest_.substr(0, end));
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_;
    if (row.empty() || row.front() == '#') continue;
    fields_.clear();
    for (std::size_t at = 0; at <= row.size();) {
      const std::size_t to =
          std::min(separator_ == ' ' ? row.find_first_of(blanks, at) : row.find(separator_, at), row.size());
      const std::string_view field = trimmed(row.substr(at, to - at));
      if (separator_ != ' ' || !field.empty()) fields_.push_back(field);
      at = to + 1;
    }
    return true;
  }
  return false;
}

double NumberTable::number(std::size_t field, const NumberColumn& column) const {
  const std::string_view text = fields_[field];
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    refuse(fmt::format("{} = {}, expected a number", column.name, printable(text)));
  if (!std::isfinite(value) || !column.bounds.hold(value))
    refuse(fmt::format("{} = {}, expected {}", column.name, printable(text),
                       column.bounds.expected(column.unit)));
  return value;
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
